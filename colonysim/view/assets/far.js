// A large place from far away: nodes are squares of a few pixels, written straight into memory.

import { mix, scaleColour } from "./palette.js";
import { shareOf } from "./marks.js";

const packed = ([red, green, blue], alpha = 255) => (alpha << 24) | (blue << 16) | (green << 8) | red;

/** Pixels of a canvas's size that squares are put into; `show` puts them on the canvas. */
export class Pixels {
  resize(width, height, ratio) {
    this.ratio = ratio;
    if (this.image?.width !== width || this.image?.height !== height) {
      this.image = new ImageData(width, height);
      this.words = new Uint32Array(this.image.data.buffer);
    }
  }

  clear(colour) { this.words.fill(colour); }

  /** Begins with what other pixels show. */
  copy(other) { this.words.set(other.words); }

  square(x, y, size, colour) {
    const { width, height } = this.image;
    const west = Math.round(x * this.ratio - size / 2), north = Math.round(y * this.ratio - size / 2);
    const left = Math.max(0, west), right = Math.min(width, west + size);
    const top = Math.max(0, north), bottom = Math.min(height, north + size);
    const { words } = this;
    for (let row = top * width; row < bottom * width; row += width) {
      for (let at = row + left; at < row + right; at++) words[at] = colour; // a call of fill() takes longer
    }
  }

  show(canvas) { canvas.getContext("2d").putImageData(this.image, 0, 0); }
}

export function drawFarGround(pixels, view) {
  const { run, camera, colours, land, layer, replay, unit } = view;
  const size = Math.max(1, Math.round(0.86 * unit * pixels.ratio));
  const ground = Uint32Array.from({ length: 32 }, (_, i) => packed(mix(colours["land-low"], colours["land-high"], i / 31)));
  const scale = Uint32Array.from({ length: 256 }, (_, i) => packed(scaleColour(i / 255)));
  const { x, y } = run.nodes;
  const put = (node, colour, wide = size) => {
    const px = camera.screenX(x[node]), py = camera.screenY(y[node]);
    if (px > -unit && py > -unit && px < camera.width + unit && py < camera.height + unit) pixels.square(px, py, wide, colour);
  };
  pixels.clear(packed(colours.sky));
  for (let i = 0; i < x.length; i++) put(i, ground[Math.round(31 * land[i])]);
  for (const [node] of run.holes) put(node, packed(colours.hole));
  if (layer) {
    for (let i = 0; i < layer.nodes.length; i++) {
      const value = replay.values[layer.slots[i]];
      if (!Number.isNaN(value)) put(layer.nodes[i], scale[Math.round(255 * Math.min(Math.max(shareOf(layer, value), 0), 1))]);
    }
  }
  put(replay.goal, packed(colours.goal), Math.max(3 * size, 9));
}

export function drawFarThings(pixels, view) {
  const { camera, colours, replay, unit } = view;
  const size = Math.max(2, Math.round(0.62 * unit * pixels.ratio));
  const box = packed(colours.box), agent = packed(colours.agent), waits = packed(colours.waiting), done = packed(colours.quiet);
  const { boxX, boxY, agentX, agentY, state, waitsFor, action } = replay;
  for (let i = 0; i < boxX.length; i++) if (replay.boxNode[i] >= 0) pixels.square(camera.screenX(boxX[i]), camera.screenY(boxY[i]), size + 1, box);
  for (let i = 0; i < agentX.length; i++) {
    if (!replay.present(i)) continue;
    const colour = state[i] ? done : waitsFor[i] >= 0 && action[i] < 0 ? waits : agent;
    pixels.square(camera.screenX(agentX[i]), camera.screenY(agentY[i]), size, colour);
  }
}
