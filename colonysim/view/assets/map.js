// The map: two canvases, one for what lies still and one for what moves, and the right amount of detail for both.

import { Camera } from "./camera.js";
import { drawFarThings, Pixels } from "./far.js";
import { drawEdges, drawFarMarks, drawMarks } from "./ground.js";
import { Heat } from "./heat.js";
import { fansOf, Land, roomiest } from "./land.js";
import { Picture, sharpen } from "./shapes.js";
import { drawChosen, drawThings } from "./things.js";

const FAR = 16; // pixels between two nodes below which edges and nodes are not drawn one by one
const WHOLE = 2400; // most pixels a side of the picture of all land, from which it is then drawn
const CROWD = 1500; // bodies that are more are dots of a few pixels from far away
const LARGE = 2000; // nodes of a place whose pheromones are not drawn anew in every frame ...
const PAUSE = 200; // ... but after so many milliseconds

export class MapView {
  constructor(run, replay, ground, things) {
    Object.assign(this, { run, replay, groundCanvas: ground, thingsCanvas: things });
    this.layer = null;
    this.agent = -1;
    this.decision = null;
    this.length = meanLength(run);
    const fans = fansOf(run);
    this.land = new Land(run, this.length, fans);
    this.numberAt = roomiest(fans);
    this.heat = new Heat(run, this.length);
    this.camera = new Camera(boundsOf(run, this.length));
    const names = ["land", "shape", "whole", "wholeShape", "heat", "edges", "ground"];
    this.pictures = Object.fromEntries(names.map((name) => [name, new Picture()]));
    this.pixels = new Pixels();
    this.drawnAt = 0;
  }

  resize() {
    this.camera.resize(this.thingsCanvas.clientWidth, this.thingsCanvas.clientHeight);
    sharpen(this.thingsCanvas);
    this.drawnPlace = "";
  }

  get version() { return this.camera.version; }

  get far() { return this.unit < FAR; }

  /** Whether bodies are but dots, and everything is one picture: laid over another it would take a browser too long. */
  get crowded() { return this.far && this.replay.agentX.length + this.replay.boxX.length > CROWD; }

  /** Sizes of signs in pixels, by how far apart nodes are. */
  measure() {
    this.unit = this.length * this.camera.scale;
    this.dot = Math.min(Math.max(0.2 * this.unit, 1.5), 17);
    const body = Math.min(Math.max(1.05 * this.dot, 2.8), 14.5);
    this.sizes = { agent: body, box: body, hole: Math.min(1.5 * this.dot, 21) };
  }

  draw(now) {
    this.measure();
    const marks = this.layer ? this.replay.markVersion : 0;
    const { surfaceVersion, episode } = this.replay;
    const place = [this.camera.version, surfaceVersion, this.theme, this.layer?.field, this.layer?.key, this.layer?.low, this.layer?.high, episode].join();
    const behind = marks !== this.drawnMarks;
    const stale = place !== this.drawnPlace || (behind && (this.land.shares.length < LARGE || now - this.drawnAt > PAUSE));
    this.late = behind && !stale; // to be drawn even if nothing else changes
    // A box that leaves a pit is drawn with what moves: then the pit is drawn anew.
    const pushed = this.far ? "" : this.replay.pushed.join("");
    if (stale || pushed !== this.drawnPushed) {
      [this.drawnPlace, this.drawnMarks, this.drawnAt, this.drawnPushed] = [place, marks, now, pushed];
      this.paint(this.groundCanvas, (pen) => this.crowded || this.paintGround(pen));
      if (this.crowded) this.pixels.take(this.pictures.ground.of(`${place} ${marks}`, this.camera, (pen) => this.paintGround(pen)));
    }
    if (this.crowded) {
      drawFarThings(this.pixels, this);
      this.pixels.show(this.thingsCanvas);
      drawChosen(sharpen(this.thingsCanvas).pen, this);
    } else this.paint(this.thingsCanvas, (pen) => drawThings(pen, this));
  }

  paint(canvas, draw) {
    const { pen, width, height } = sharpen(canvas);
    pen.clearRect(0, 0, width, height);
    draw(pen);
  }

  paintGround(pen) {
    const { camera, pictures } = this;
    const { width, height } = camera;
    const lay = (picture) => pen.drawImage(picture, 0, 0, width, height);
    const view = `${camera.version} ${this.theme}`;
    lay(pictures.land.of(view, camera, (own) => this.paintLand(own, false)));
    if (this.heat.update(this.replay, this.layer)) {
      const shape = pictures.shape.of(view, camera, (own) => this.paintLand(own, true));
      lay(pictures.heat.of(`${view} ${this.heat.version}`, camera, (own) => {
        own.drawImage(shape, 0, 0, width, height);
        this.heat.draw(own, camera);
      }));
    }
    if (this.far) {
      drawFarMarks(pen, this);
      return;
    }
    lay(pictures.edges.of(`${view} ${this.replay.surfaceVersion}`, camera, (own) => drawEdges(own, this)));
    drawMarks(pen, this);
  }

  /** Land, `bare` without coast and water. From far away all of it is drawn once, and moved about as a picture. */
  paintLand(pen, bare) {
    const { camera, colours, land } = this;
    if (!this.far) {
      land.draw(pen, { camera, colours }, bare);
      return;
    }
    const [west, south, east, north] = camera.bounds;
    const [wide, high] = [east - west, north - south];
    const scale = Math.min(FAR / this.length, WHOLE / (window.devicePixelRatio || 1) / Math.max(wide, high));
    const whole = { x: (west + east) / 2, y: (south + north) / 2, scale, width: wide * scale, height: high * scale };
    const picture = this.pictures[bare ? "wholeShape" : "whole"].of(this.theme, whole, (own) => land.draw(own, { camera: whole, colours }, bare));
    pen.imageSmoothingQuality = "high";
    pen.drawImage(picture, camera.screenX(west), camera.screenY(north), wide * camera.scale, high * camera.scale);
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
