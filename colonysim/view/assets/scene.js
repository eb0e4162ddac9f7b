// The run's rigid bodies in 3D: ground with pits and ramps, boxes, robots, where their poses say they were. Metres.

import { lookAt, multiply, perspective, quaternion, turn, unitVector } from "./matrices.js";
import { mix, scaleColour, style } from "./palette.js";
import { agentLabel, boxLabel, disc, segment, word, writeSign } from "./shapes.js";
import { shareOf } from "./marks.js";
import { GROUND, Solids } from "./solids.js";
import { percent } from "./things.js";

const SUN = unitVector([-0.6, -0.5, 0.8]);
const FLAT = quaternion(Math.PI / 2, 0, 0); // a cylinder standing upright
const CROWDED = 26; // pixels between two nodes below which their numbers are left away
const part = (colour) => colour.map((value) => value / 255);

export class SceneView {
  /** `map` is the same place seen from above: it knows the heat of the ground and where numbers have room. */
  constructor(run, replay, canvas, map) {
    Object.assign(this, { run, replay, canvas, heat: map.heat, numberAt: map.numberAt });
    this.solids = new Solids(canvas);
    this.edge = map.length * run.bodies.scale; // metres of an edge
    this.version = 0;
    this.layer = null;
    this.agent = -1;
    this.decision = null;
    const { places } = run.bodies;
    this.home = [0, 1, 2].map((axis) => {
      const [low, high] = rangeOf(places.map((place) => place[axis]));
      return (low + high) / 2;
    });
    this.size = rangeOf(places.map((place) => Math.hypot(place[0] - this.home[0], place[1] - this.home[1])))[1] + 2.5;
    this.fit();
  }

  fit() {
    this.target = [...this.home];
    this.distance = 1;
    this.heading = -Math.PI / 2;
    this.tilt = 0.95;
    this.version++;
  }

  drag(dx, dy, second) {
    this.version++;
    if (!second) {
      this.heading -= dx * 0.006;
      this.tilt = Math.min(Math.max(this.tilt + dy * 0.006, 0.08), 1.55);
      return;
    }
    const step = (1.2 * this.far()) / this.canvas.clientHeight;
    const [c, s] = [Math.cos(this.heading), Math.sin(this.heading)];
    this.target[0] += step * (s * dx + c * -dy);
    this.target[1] += step * (-c * dx + s * -dy);
  }

  zoom(factor) {
    this.distance = Math.min(Math.max(this.distance / factor, 0.12), 3);
    this.version++;
  }

  resize() { this.version++; }

  far() {
    const aspect = this.canvas.clientWidth / Math.max(1, this.canvas.clientHeight);
    return (this.distance * this.size * 1.74) / Math.min(1, 0.8 * aspect);
  }

  draw(pen) {
    const { width, height, ratio } = measure(this.canvas);
    const away = this.far();
    const eye = [
      this.target[0] + away * Math.cos(this.tilt) * Math.cos(this.heading),
      this.target[1] + away * Math.cos(this.tilt) * Math.sin(this.heading),
      this.target[2] + away * Math.sin(this.tilt),
    ];
    this.view = multiply(perspective(0.8, width / height, away / 50, away * 4), lookAt(eye, this.target));
    this.solids.load(this.bodies());
    this.warm();
    this.solids.draw(this.view, { eye, centre: this.home, radius: this.size + 1, sun: SUN, sky: part(this.colours.sky) });
    this.labels(pen, width, height, ratio);
  }

  /** Lays the shown pheromone on the ground. */
  warm() {
    const shown = this.heat.update(this.replay, this.layer);
    const state = shown ? this.heat.version : -1;
    if (state === this.warmed) return;
    this.warmed = state;
    this.solids.warm(shown ? this.heat.image : new ImageData(1, 1), this.heat.bounds.map((value) => value * this.run.bodies.scale));
  }

  bodies() {
    const { run, replay, colours } = this;
    const { bodies } = run;
    this.ground ??= new Map();
    if (!this.ground.has(this.theme)) this.ground.set(this.theme, groundOf(run, colours));
    const cuboids = [...this.ground.get(this.theme)];
    const cylinders = this.marks();
    this.addFlag(cuboids);
    const agents = replay.agentNode.length;
    this.at = [];
    for (let box = 0; box < replay.boxNode.length; box++) {
      if (replay.boxNode[box] < 0 || !replay.poseOf(agents + box)) continue;
      const [x, y, z, roll, pitch, yaw] = replay.pose;
      const [length, high] = bodies.boxes[box];
      const colour = this.layer?.by === "box" && this.layer.key === box ? colours["box-line"] : colours.box;
      cuboids.push([[x, y, z], [length / 2, length / 2, high / 2], quaternion(roll, pitch, yaw), part(colour), [0.03]]);
      this.at.push({ box, place: [x, y, z + high / 2 + 0.05] });
    }
    for (let agent = 0; agent < agents; agent++) {
      if (!replay.present(agent) || !replay.poseOf(agent)) continue;
      this.addRobot(cuboids, cylinders, agent, [...replay.pose]);
    }
    return { cuboid: cuboids, cylinder: cylinders };
  }

  addRobot(cuboids, cylinders, agent, [x, y, z, roll, pitch, yaw]) {
    const { colours } = this;
    const [ahead, wide, track, wheel, size] = this.run.bodies.robots[agent];
    const rotation = quaternion(roll, pitch, yaw);
    const put = (offset) => turn(rotation, offset).map((value, i) => value + [x, y, z][i]);
    const s = (standard) => size * standard;
    const paint = part(agent === this.agent ? mix(colours.agent, [255, 255, 255], 0.35) : colours.agent);
    const dark = part(mix(colours.agent, [20, 20, 30], 0.72));
    cuboids.push([put([0, 0, s(0.2)]), [ahead, 0.62 * track, s(0.1)], rotation, paint, [s(0.025)]]);
    cuboids.push([put([s(-0.08), 0, s(0.33)]), [0.5 * ahead, 0.4 * track, s(0.04)], rotation, paint, [s(0.02)]]);
    cuboids.push([put([ahead - s(0.03), 0, s(0.17)]), [s(0.04), 0.66 * track, s(0.1)], rotation, dark, [0]]);
    for (const side of [-1, 1]) {
      const lamp = [put([ahead - s(0.06), side * 0.35 * track, s(0.302)]), [s(0.03), s(0.05), s(0.01)]];
      cuboids.push([...lamp, rotation, [1, 0.97, 0.8], [0]]);
      for (const axle of [-1, 1]) {
        const hub = put([axle * s(0.22), side * (wide - s(0.05)), wheel]);
        cylinders.push([hub, [wheel, s(0.05), wheel], rotation, [0.13, 0.14, 0.16], [0]]);
      }
    }
    this.at.push({ agent, place: put([0, 0, s(0.45)]) });
  }

  addFlag(cuboids) {
    const [x, y, z] = this.run.bodies.places[this.replay.goal];
    const green = part(this.colours.goal);
    cuboids.push([[x, y, z + 0.7], [0.03, 0.03, 0.7], [0, 0, 0, 1], part(this.colours["node-line"]), [0]]);
    cuboids.push([[x + 0.3, y, z + 1.2], [0.28, 0.015, 0.18], [0, 0, 0, 1], green, [0]]);
  }

  /** Nodes as small discs, with their pheromone if it is shown; the goal as a flag. */
  marks() {
    const { run, replay, layer, colours } = this;
    const shown = new Map();
    layer?.nodes.forEach((node, i) => {
      const value = replay.values[layer.slots[i]];
      if (!Number.isNaN(value)) shown.set(node, scaleColour(shareOf(layer, value)));
    });
    const holes = new Set(run.holes.map(([node]) => node));
    const discs = [];
    run.bodies.places.forEach(([x, y, z], node) => {
      if (holes.has(node)) return;
      const colour = node === replay.goal ? colours.goal : shown.get(node) ?? colours["node-line"];
      const radius = node === replay.goal ? 0.5 : shown.has(node) ? 0.19 : 0.12;
      discs.push([[x, y, z + 0.02], [radius, 0.006, radius], FLAT, part(colour), [0]]);
    });
    return discs;
  }

  labels(pen, width, height) {
    this.shown = this.at.map((thing) => ({ ...thing, screen: this.project(thing.place, width, height) })).filter(({ screen }) => screen);
    this.numbers(pen, width, height);
    if (this.decision && this.agent >= 0 && this.replay.present(this.agent)) this.choices(pen, width, height);
    const dark = style(mix(this.colours.box, [0, 0, 0], 0.55));
    for (const { agent, box, screen: [x, y, metre] } of this.shown) {
      if (agent === undefined) word(pen, boxLabel(box), x, y, Math.min(Math.max(0.32 * metre, 10), 18), "#ffffff", dark, 700);
      else this.pin(pen, agent, x, y, metre);
    }
  }

  /** The label of a robot stands above it, so that the robot itself is to be seen. */
  pin(pen, agent, x, y, metre) {
    const { css } = this.colours;
    const radius = Math.min(Math.max(0.26 * metre, 9), 14);
    const top = y - 0.42 * metre - 1.5 * radius;
    pen.beginPath();
    segment(pen, x, top + radius, x, y);
    pen.strokeStyle = css["agent-line"];
    pen.lineWidth = 1.5;
    pen.stroke();
    disc(pen, x, top, radius, css.agent, css["agent-line"], 1.5);
    writeSign(pen, agentLabel(agent), x, top, radius, "#101010");
    if (agent === this.agent) disc(pen, x, top, radius + 3.5, null, css.ink, 2.5);
  }

  /** The numbers of nodes on the ground, except below robots and boxes; nodes that are too close together have none. */
  numbers(pen, width, height) {
    const { run, colours } = this;
    const { places, pits } = run.bodies;
    const holes = new Map(run.holes.map(([node], i) => [node, pits[i]]));
    this.numbered = [];
    places.forEach(([x, y, z], node) => {
      const out = holes.has(node) ? 0.5 * holes.get(node)[3] + 0.35 : 0.38;
      const screen = this.project([x + out * Math.cos(this.numberAt[node]), y + out * Math.sin(this.numberAt[node]), z], width, height);
      if (!screen || screen[2] * this.edge < CROWDED) return;
      const size = Math.min(Math.max(0.26 * screen[2], 9.5), 14);
      if (this.shown.some((thing) => Math.hypot(thing.screen[0] - screen[0], thing.screen[1] - screen[1]) < 0.35 * screen[2] + size)) return;
      this.numbered.push({ node, screen });
      word(pen, run.nodes.id[node], screen[0], screen[1], size, this.layer ? colours.css.ink : colours.css.quiet, colours.css["land-high"], 500);
    });
  }

  choices(pen, width, height) {
    const { places } = this.run.bodies;
    const from = this.project(places[this.decision.node], width, height);
    for (const { target, chance } of this.decision.choices) {
      const to = target >= 0 && this.project(places[target], width, height);
      if (!from || !to) continue;
      pen.strokeStyle = this.colours.css["agent-line"];
      pen.globalAlpha = target === this.decision.chosen ? 0.95 : 0.5;
      pen.lineWidth = 1.5 + 6 * chance;
      pen.beginPath();
      segment(pen, from[0], from[1], to[0], to[1]);
      pen.stroke();
      pen.globalAlpha = 1;
      word(pen, percent(chance), (from[0] + to[0]) / 2, (from[1] + to[1]) / 2, 12, this.colours.css.ink, this.colours.css.card);
    }
  }

  /** A place on the screen, with the pixels of a metre there; null if it is behind the eye. */
  project([x, y, z], width, height) {
    const m = this.view;
    const w = m[3] * x + m[7] * y + m[11] * z + m[15];
    if (w <= 0) return null;
    const px = (m[0] * x + m[4] * y + m[8] * z + m[12]) / w, py = (m[1] * x + m[5] * y + m[9] * z + m[13]) / w;
    return [(0.5 + 0.5 * px) * width, (0.5 - 0.5 * py) * height, height / (0.845 * w)];
  }

  find(px, py) {
    const near = (this.shown ?? []).filter(({ screen }) => Math.hypot(screen[0] - px, screen[1] - py) < Math.max(22, 0.5 * screen[2]));
    near.sort((a, b) => Math.hypot(a.screen[0] - px, a.screen[1] - py) - Math.hypot(b.screen[0] - px, b.screen[1] - py));
    return near[0] ?? {};
  }
}

/** The least and the largest of many numbers: more than a call takes as arguments. */
function rangeOf(values) {
  return values.reduce(([low, high], value) => [Math.min(low, value), Math.max(high, value)], [Infinity, -Infinity]);
}

function measure(canvas) {
  const ratio = window.devicePixelRatio || 1;
  const width = canvas.clientWidth, height = canvas.clientHeight;
  const [w, h] = [Math.max(1, Math.round(width * ratio)), Math.max(1, Math.round(height * ratio))];
  if (canvas.width !== w || canvas.height !== h) [canvas.width, canvas.height] = [w, h];
  return { width: Math.max(1, width), height: Math.max(1, height), ratio };
}

/** The fixed ground, lower parts darker; the floors of pits darkest. */
function groundOf(run, colours) {
  const { slabs } = run;
  const tops = run.bodies.places.map((place) => place[2]);
  const [low, high] = rangeOf(tops);
  const grounds = [];
  const shade = (colour) => part(mix(colour, colours.coast, 0.12));
  for (let i = 0; i < slabs.length; i += 8) {
    const [x, y, z, a, b, c, yaw, slope] = slabs.subarray(i, i + 8);
    const top = z + c * Math.cos(slope);
    const inPit = run.bodies.pits.some(([px, py, , side, rim]) => (
      Math.hypot(px - x, py - y) < 0.01 && rim - top > 0.02 && a < side
    ));
    const share = high > low ? Math.min(Math.max((top - low) / (high - low), 0), 1) : 0.75;
    const colour = inPit ? mix(colours.hole, colours["land-low"], 0.3) : mix(colours["land-low"], colours["land-high"], share);
    // A little larger than it is: no cracks between neighbours.
    grounds.push([[x, y, z], [a + 0.004, b + 0.004, c], quaternion(0, -slope, yaw), shade(colour), [GROUND]]);
  }
  return [...grounds, ...waysOf(run, colours)];
}

/** The graph's edges as thin strips on the ground, up to the rims of pits. */
function waysOf(run, colours) {
  const { places } = run.bodies;
  const holes = new Set(run.holes.map(([node]) => node));
  const colour = part(colours.way);
  return Array.from(run.edges.a, (a, i) => {
    const b = run.edges.b[i];
    const [from, to] = [places[a], places[b]];
    const flat = Math.hypot(to[0] - from[0], to[1] - from[1]), rise = to[2] - from[2];
    const [begin, end] = [a, b].map((node) => (holes.has(node) ? 0.8 : 0));
    const middle = (0.5 * (begin + flat - end)) / flat;
    const centre = from.map((value, axis) => value + middle * (to[axis] - value) + (axis === 2 ? 0.012 : 0));
    const length = ((flat - begin - end) / flat) * Math.hypot(flat, rise);
    const rotation = quaternion(0, -Math.atan2(rise, flat), Math.atan2(to[1] - from[1], to[0] - from[0]));
    return [centre, [length / 2, 0.026, 0.003], rotation, colour, [0]];
  });
}
