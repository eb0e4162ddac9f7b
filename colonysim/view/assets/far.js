// Many bodies from far away: squares of a few pixels, written straight into memory.

const packed = ([red, green, blue], alpha = 255) => (alpha << 24) | (blue << 16) | (green << 8) | red;

/** Pixels of a canvas's size: a ground that is kept, and squares that are put on it; `show` puts them on the canvas. */
export class Pixels {
  /** Takes a picture as the ground. */
  take(canvas) {
    const { width, height } = canvas;
    this.ground = new Uint32Array(canvas.getContext("2d").getImageData(0, 0, width, height).data.buffer);
    if (this.image?.width !== width || this.image?.height !== height) {
      this.image = new ImageData(width, height);
      this.words = new Uint32Array(this.image.data.buffer);
    }
  }

  /** Begins anew with the ground alone. */
  clear() {
    this.ratio = window.devicePixelRatio || 1;
    this.words.set(this.ground);
  }

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

export function drawFarThings(pixels, view) {
  const { camera, colours, replay, unit } = view;
  pixels.clear();
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
