// Pheromones as heat of the ground: the values of nodes, smoothed over the place and along the edges between them.

import { scaleColour } from "./palette.js";
import { shareOf } from "./marks.js";

const FINE = 9; // cells to a mean length of an edge ...
const MOST = 2e5; // ... unless these are too many
const SPREAD = 0.8; // how far a value reaches, in mean lengths of an edge
const APART = [0.6, 1.05]; // how far apart values lie along an edge, in the same: on a fine raster, on a coarse one
const SOLID = 0.65; // weight from which on a cell is as opaque as it gets
const OPAQUE = 215; // of 255

const SCALE = Uint32Array.from({ length: 256 }, (_, i) => {
  const [red, green, blue] = scaleColour(i / 255);
  return (blue << 16) | (green << 8) | red;
});
const STEPS = 64;
const COVER = Uint32Array.from({ length: STEPS + 1 }, (_, i) => { // soft where it ends
  const share = i / STEPS;
  return Math.round(OPAQUE * share * share * (3 - 2 * share)) << 24;
});

/** A raster over the place; `canvas` is its picture, `bounds` (west, south, east, north) where that lies. */
export class Heat {
  constructor(run, length) {
    this.run = run;
    const { x, y } = run.nodes;
    const range = (values) => values.reduce(([low, high], value) => [Math.min(low, value), Math.max(high, value)], [Infinity, -Infinity]);
    const [[west, east], [south, north]] = [range(x), range(y)];
    this.bounds = [west - length, south - length, east + length, north + length];
    const [wide, high] = [east - west + 2 * length, north - south + 2 * length];
    this.fine = Math.min(FINE / length, Math.sqrt(MOST / (wide * high))); // cells to a unit
    [this.columns, this.rows] = [Math.ceil(wide * this.fine), Math.ceil(high * this.fine)];
    this.reach = Math.max(SPREAD * length * this.fine, 1);
    this.apart = APART[this.fine * length < FINE ? 1 : 0] * length;
    this.canvas = new OffscreenCanvas(this.columns, this.rows);
    this.image = new ImageData(this.columns, this.rows);
    this.words = new Uint32Array(this.image.data.buffer);
    this.sums = new Float32Array(this.words.length);
    this.weights = new Float32Array(this.words.length);
    this.shares = new Float32Array(x.length);
    this.version = 0;
  }

  /** Brings the picture up to date; false if a layer has no heat: the worth of a box stands on holes alone. */
  update(replay, layer) {
    if (!layer || layer.by === "box") return false;
    const state = [replay.episode, replay.markVersion, layer.field, layer.key, layer.low, layer.high].join();
    if (state === this.state) return true;
    this.state = state;
    this.version++;
    this.gather(replay, layer);
    this.paint();
    return true;
  }

  gather(replay, layer) {
    const { nodes, edges } = this.run;
    const { shares } = this;
    shares.fill(NaN);
    layer.nodes.forEach((node, i) => {
      const value = replay.values[layer.slots[i]];
      if (!Number.isNaN(value)) shares[node] = Math.min(Math.max(shareOf(layer, value), 0), 1);
    });
    this.sums.fill(0);
    this.weights.fill(0);
    for (const node of layer.nodes) if (!Number.isNaN(shares[node])) this.drop(nodes.x[node], nodes.y[node], shares[node]);
    for (let e = 0; e < edges.a.length; e++) {
      const [a, b] = [edges.a[e], edges.b[e]];
      const [from, to] = [shares[a], shares[b]];
      if (Number.isNaN(from) || Number.isNaN(to)) continue;
      const [dx, dy] = [nodes.x[b] - nodes.x[a], nodes.y[b] - nodes.y[a]];
      const parts = Math.ceil(Math.hypot(dx, dy) / this.apart);
      for (let i = 1; i < parts; i++) {
        const share = i / parts;
        this.drop(nodes.x[a] + share * dx, nodes.y[a] + share * dy, from + share * (to - from));
      }
    }
  }

  /** Adds a value at a place, the less the farther away. */
  drop(x, y, value) {
    const { reach, columns, rows, sums, weights } = this;
    const column = (x - this.bounds[0]) * this.fine - 0.5, row = (this.bounds[3] - y) * this.fine - 0.5;
    const west = Math.max(Math.ceil(column - reach), 0), east = Math.min(Math.floor(column + reach), columns - 1);
    const south = Math.min(Math.floor(row + reach), rows - 1), per = 1 / (reach * reach);
    for (let i = Math.max(Math.ceil(row - reach), 0); i <= south; i++) {
      const left = 1 - (i - row) * (i - row) * per;
      for (let j = west, at = i * columns + west; j <= east; j++, at++) {
        const near = left - (j - column) * (j - column) * per;
        if (near <= 0) continue;
        sums[at] += near * near * value;
        weights[at] += near * near;
      }
    }
  }

  paint() {
    const { sums, weights, words } = this;
    for (let i = 0; i < words.length; i++) {
      const weight = weights[i];
      if (weight === 0) words[i] = 0;
      else words[i] = SCALE[(255 * sums[i]) / weight + 0.5 | 0] | COVER[weight < SOLID ? (STEPS * weight) / SOLID | 0 : STEPS];
    }
    this.canvas.getContext("2d").putImageData(this.image, 0, 0);
  }

  /** Draws the heat on what is painted already, and nowhere else. */
  draw(pen, camera) {
    const [west, south, east, north] = this.bounds;
    pen.globalCompositeOperation = "source-in";
    pen.imageSmoothingEnabled = true;
    pen.imageSmoothingQuality = "high";
    pen.drawImage(this.canvas, camera.screenX(west), camera.screenY(north), (this.columns / this.fine) * camera.scale, (this.rows / this.fine) * camera.scale);
    pen.globalCompositeOperation = "source-over";
  }
}
