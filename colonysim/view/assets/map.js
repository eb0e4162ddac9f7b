// The map: two canvases, one for what lies still and one for what moves, and the right amount of detail for both.

import { Camera } from "./camera.js";
import { drawFarGround, drawFarThings, Pixels } from "./far.js";
import { drawMarks, drawPlace, landShares } from "./ground.js";
import { sharpen } from "./shapes.js";
import { drawChosen, drawThings } from "./things.js";

const FAR = 16; // pixels between two nodes below which the place is seen from far away
const LARGE = 2000; // nodes of a place whose pheromones are not drawn anew in every frame ...
const PAUSE = 200; // ... but after so many milliseconds

export class MapView {
  constructor(run, replay, ground, things) {
    Object.assign(this, { run, replay, groundCanvas: ground, thingsCanvas: things });
    this.layer = null;
    this.agent = -1;
    this.decision = null;
    this.land = landShares(run);
    this.length = meanLength(run);
    this.camera = new Camera(boundsOf(run, this.length));
    [this.ground, this.all] = [new Pixels(), new Pixels()];
    this.drawnAt = 0;
  }

  resize() {
    this.camera.resize(this.thingsCanvas.clientWidth, this.thingsCanvas.clientHeight);
    sharpen(this.thingsCanvas);
    this.drawnPlace = "";
  }

  get version() { return this.camera.version; }

  get far() { return this.unit < FAR; }

  draw(now) {
    this.unit = this.length * this.camera.scale;
    this.dot = Math.min(Math.max(0.2 * this.unit, 1.5), 17);
    const marks = this.layer ? this.replay.markVersion : 0;
    const { surfaceVersion, episode } = this.replay;
    const place = [this.camera.version, surfaceVersion, this.theme, this.layer?.field, this.layer?.key, episode].join();
    const behind = marks !== this.drawnMarks;
    const stale = place !== this.drawnPlace || (behind && (this.land.length < LARGE || now - this.drawnAt > PAUSE));
    this.late = behind && !stale; // to be drawn even if nothing else changes
    // A box that leaves a pit is drawn with what moves: then the pit is drawn anew.
    const pushed = this.far ? "" : this.replay.pushed.join("");
    if (stale || pushed !== this.drawnPushed) {
      if (place !== this.drawnPlace && !this.far) this.paintPlace();
      [this.drawnPlace, this.drawnMarks, this.drawnAt, this.drawnPushed] = [place, marks, now, pushed];
      if (this.far) this.paintFarGround();
      else this.paint(this.groundCanvas, (pen) => this.paintMarks(pen));
    }
    if (this.far) this.paintFarThings();
    else this.paint(this.thingsCanvas, (pen) => drawThings(pen, this));
  }

  paint(canvas, draw) {
    const { pen, width, height } = sharpen(canvas);
    pen.clearRect(0, 0, width, height);
    draw(pen);
  }

  // From far away both are one picture: a browser without a graphics card takes long to lay one over the other.

  paintFarGround() {
    const { width, height } = this.thingsCanvas;
    for (const pixels of [this.ground, this.all]) pixels.resize(width, height, window.devicePixelRatio || 1);
    drawFarGround(this.ground, this);
    const { pen } = sharpen(this.groundCanvas);
    pen.clearRect(0, 0, this.camera.width, this.camera.height);
  }

  paintFarThings() {
    this.all.copy(this.ground);
    drawFarThings(this.all, this);
    this.all.show(this.thingsCanvas);
    drawChosen(sharpen(this.thingsCanvas).pen, this);
  }

  paintPlace() {
    const { ratio, width, height } = sharpen(this.groundCanvas);
    this.place = new OffscreenCanvas(Math.max(1, Math.round(width * ratio)), Math.max(1, Math.round(height * ratio)));
    const pen = this.place.getContext("2d");
    pen.scale(ratio, ratio);
    drawPlace(pen, this);
  }

  paintMarks(pen) {
    pen.drawImage(this.place, 0, 0, this.camera.width, this.camera.height);
    drawMarks(pen, this);
  }

  clear() {
    const { pen, width, height } = sharpen(this.thingsCanvas);
    pen.clearRect(0, 0, width, height);
    return pen;
  }

  /** What lies at a point of the screen: { agent }, { box }, { hole } (its node), or {}. */
  find(px, py) {
    const { camera, replay, run } = this;
    const reach = Math.max(1.6 * this.dot, 14);
    const nearest = (count, place) => {
      let found = -1, best = reach;
      for (let i = 0; i < count; i++) {
        const at = place(i);
        if (!at) continue;
        const away = Math.hypot(camera.screenX(at[0]) - px, camera.screenY(at[1]) - py);
        if (away < best) [found, best] = [i, away];
      }
      return [found, best];
    };
    const [agent, near] = nearest(replay.agentX.length, (i) => replay.present(i) && [replay.agentX[i], replay.agentY[i]]);
    const [box, nearer] = nearest(replay.boxX.length, (i) => [replay.boxX[i], replay.boxY[i]]);
    const [hole] = nearest(run.holes.length, (i) => [run.nodes.x[run.holes[i][0]], run.nodes.y[run.holes[i][0]]]);
    const found = {};
    if (hole >= 0) found.hole = run.holes[hole][0];
    if (box >= 0) found.box = box;
    if (agent >= 0 && (box < 0 || near <= nearer + 0.9 * this.dot)) found.agent = agent;
    return found;
  }
}

function meanLength({ nodes, edges }) {
  let sum = 0;
  for (let e = 0; e < edges.a.length; e++) {
    sum += Math.hypot(nodes.x[edges.a[e]] - nodes.x[edges.b[e]], nodes.y[edges.a[e]] - nodes.y[edges.b[e]]);
  }
  return edges.a.length ? sum / edges.a.length : 1;
}

function boundsOf({ nodes }, length) {
  let [west, south, east, north] = [Infinity, Infinity, -Infinity, -Infinity];
  for (let i = 0; i < nodes.x.length; i++) {
    west = Math.min(west, nodes.x[i]);
    east = Math.max(east, nodes.x[i]);
    south = Math.min(south, nodes.y[i]);
    north = Math.max(north, nodes.y[i]);
  }
  return [west - 0.8 * length, south - 0.8 * length, east + 0.8 * length, north + 0.8 * length];
}
