// What lies still: land, edges, nodes with their pheromone, holes and how full they are. Drawn when it changes.

import { mix, onScale, scaleStyle, style } from "./palette.js";
import { diamond, segment, square, Stamp, word } from "./shapes.js";
import { shareOf } from "./marks.js";

/** Heights of the place: each node's bare ground (a hole's rim), from 0 (lowest) to 1. */
export function landShares(run) {
  const heights = Array.from(run.nodes.z);
  for (const [node, , rim] of run.holes) heights[node] = rim;
  let low = Infinity, high = -Infinity;
  for (const height of heights) {
    low = Math.min(low, height);
    high = Math.max(high, height);
  }
  return Float32Array.from(heights, (height) => (high > low ? (height - low) / (high - low) : 0.75));
}

/** The edges that nobody can pass: their ends are not level (paper Section 3.3), or the edge has been taken away. */
export function isBlocked(run, { surface, taken }, edge) {
  const { a, b, rise } = run.edges;
  return taken[edge] === 1 || Math.abs(surface[b[edge]] - surface[a[edge]] - rise[edge]) >= run.reach - 1e-5;
}

/** Land and edges: what changes only with the surfaces. */
export function drawPlace(pen, view) {
  const place = onScreen(view);
  drawLand(pen, view, place);
  drawEdges(pen, view, place);
}

/** Nodes and holes, with what lies on them and in them. */
export function drawMarks(pen, view) {
  const place = onScreen(view);
  drawNodes(pen, view, place);
  drawHoles(pen, view, place);
}

function onScreen({ run, camera }) {
  const xs = Float32Array.from(run.nodes.x, (x) => camera.screenX(x));
  const ys = Float32Array.from(run.nodes.y, (y) => camera.screenY(y));
  const seen = (i, room) => xs[i] > -room && ys[i] > -room && xs[i] < camera.width + room && ys[i] < camera.height + room;
  return { xs, ys, seen };
}

/** Land is where edges are: broad strokes, low ground first, with a coast around all of it. */
function drawLand(pen, { run, colours, unit, land, camera }, { xs, ys, seen }) {
  const { a, b, rise } = run.edges;
  const broad = unit * 0.95;
  const colour = (share) => style(mix(colours["land-low"], colours["land-high"], share));
  const near = [];
  for (let e = 0; e < a.length; e++) if (seen(a[e], 2 * unit) || seen(b[e], 2 * unit)) near.push(e);
  pen.lineCap = pen.lineJoin = "round";
  pen.beginPath();
  for (const e of near) segment(pen, xs[a[e]], ys[a[e]], xs[b[e]], ys[b[e]]);
  pen.lineWidth = broad + 3;
  pen.strokeStyle = colours.css.coast;
  pen.stroke();
  pen.lineWidth = broad;
  const levels = new Map();
  for (const e of near) {
    if (rise[e]) continue;
    const share = Math.min(land[a[e]], land[b[e]]);
    if (!levels.has(share)) levels.set(share, []);
    levels.get(share).push(e);
  }
  for (const e of near.filter((each) => rise[each])) {
    const shade = pen.createLinearGradient(xs[a[e]], ys[a[e]], xs[b[e]], ys[b[e]]);
    shade.addColorStop(0, colour(land[a[e]]));
    shade.addColorStop(1, colour(land[b[e]]));
    pen.strokeStyle = shade;
    pen.beginPath();
    segment(pen, xs[a[e]], ys[a[e]], xs[b[e]], ys[b[e]]);
    pen.stroke();
  }
  for (const share of [...levels.keys()].sort((one, other) => one - other)) {
    pen.strokeStyle = colour(share);
    pen.beginPath();
    for (const e of levels.get(share)) segment(pen, xs[a[e]], ys[a[e]], xs[b[e]], ys[b[e]]);
    pen.stroke();
  }
  pen.lineCap = "butt";
}

function drawEdges(pen, { run, colours, unit, dot, replay }, { xs, ys, seen }) {
  const { a, b, rise } = run.edges;
  const paths = { flat: new Path2D(), slope: new Path2D(), arrow: new Path2D(), blocked: new Path2D() };
  for (let e = 0; e < a.length; e++) {
    if (!seen(a[e], unit) && !seen(b[e], unit)) continue;
    const [x0, y0, x1, y1] = [xs[a[e]], ys[a[e]], xs[b[e]], ys[b[e]]];
    if (!replay.taken[e]) segment(rise[e] ? paths.slope : paths.flat, x0, y0, x1, y1);
    const x = (x0 + x1) / 2, y = (y0 + y1) / 2, angle = Math.atan2(y1 - y0, x1 - x0);
    if (rise[e] && dot > 5) { // an arrow points uphill
      const way = rise[e] > 0 ? angle : angle + Math.PI, size = 0.5 * dot;
      for (const side of [2.5, -2.5]) segment(paths.arrow, x, y, x + size * Math.cos(way + side), y + size * Math.sin(way + side));
    }
    if (isBlocked(run, replay, e)) { // 60 degrees to the edge, so that it reads as a slash
      const dx = 0.16 * unit * Math.cos(angle + Math.PI / 3), dy = 0.16 * unit * Math.sin(angle + Math.PI / 3);
      segment(paths.blocked, x - dx, y - dy, x + dx, y + dy);
    }
  }
  pen.strokeStyle = colours.css.way;
  pen.lineWidth = dot > 5 ? 1.5 : 1;
  pen.stroke(paths.flat);
  pen.setLineDash([6, 4]);
  pen.stroke(paths.slope);
  pen.setLineDash([]);
  pen.lineWidth = 2;
  pen.stroke(paths.arrow);
  pen.strokeStyle = colours.css.blocked;
  pen.lineWidth = dot > 5 ? 3 : 1.5;
  pen.lineCap = "round";
  pen.stroke(paths.blocked);
  pen.lineCap = "butt";
}

function drawNodes(pen, { run, colours, dot, replay, layer }, { xs, ys, seen }) {
  const { css } = colours;
  const shown = new Map();
  layer?.nodes.forEach((node, i) => {
    const value = replay.values[layer.slots[i]];
    if (!Number.isNaN(value)) shown.set(node, shareOf(layer, value));
  });
  const holes = new Set(run.holes.map(([node]) => node));
  const stamp = new Stamp(dot, css["node-line"], 1, window.devicePixelRatio || 1);
  const numbered = dot > 8;
  for (let i = 0; i < xs.length; i++) {
    if (!seen(i, dot) || holes.has(i)) continue;
    // On 64 steps of the scale, each of which is painted once.
    stamp.draw(pen, xs[i], ys[i], shown.has(i) ? scaleStyle(Math.round(63 * shown.get(i)) / 63) : css.node);
  }
  diamond(pen, xs[replay.goal], ys[replay.goal], 1.75 * dot, null, css.goal, Math.max(2, dot / 4));
  if (dot <= 5) diamond(pen, xs[replay.goal], ys[replay.goal], dot + 2, css.goal);
  if (!numbered) return;
  for (let i = 0; i < xs.length; i++) {
    if (!seen(i, dot) || holes.has(i)) continue;
    word(pen, run.nodes.id[i], xs[i], ys[i], Math.min(0.85 * dot, 13), shown.has(i) ? onScale(shown.get(i)) : css.quiet);
  }
}

/** A hole is a dark square; the boxes in it lie in it as they do in the pit, one above the other. */
function drawHoles(pen, { run, colours, dot, replay, layer }, { xs, ys, seen }) {
  const { css } = colours;
  const half = 1.25 * dot;
  for (const [node, floor, rim] of run.holes) {
    if (!seen(node, half)) continue;
    const [x, y] = [xs[node], ys[node]];
    square(pen, x, y, half, css.hole, css["hole-line"], 1.5);
    let bottom = y + half;
    for (const box of replay.stacks.get(node) ?? []) {
      const high = Math.min((2 * half * run.boxes.height[box]) / (rim - floor), bottom - (y - half));
      if (!replay.seated(box) || high <= 0) continue;
      pen.fillStyle = css.box;
      pen.strokeStyle = css["box-line"];
      pen.lineWidth = 1;
      pen.beginPath();
      pen.roundRect(x - half + 1, bottom - high, 2 * half - 2, high, 2);
      pen.fill();
      pen.stroke();
      bottom -= high;
    }
    const at = layer ? [...layer.nodes].indexOf(node) : -1;
    const value = at < 0 ? NaN : replay.values[layer.slots[at]];
    if (!Number.isNaN(value)) square(pen, x, y, 0.75 * half, scaleStyle(shareOf(layer, value)), css.card, 1);
    const readable = Number.isNaN(value) ? "#ffffff" : onScale(shareOf(layer, value));
    if (dot > 8) word(pen, run.nodes.id[node], x, y, Math.min(0.85 * dot, 13), readable);
    const fill = Math.round((100 * (replay.surface[node] - floor)) / (rim - floor));
    if (dot > 8) word(pen, `${fill} %`, x, y + half + 9, 11, css.ink, css["land-high"]);
  }
}
