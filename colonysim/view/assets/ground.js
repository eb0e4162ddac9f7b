// What lies still: edges, trails, nodes with their numbers, holes and how full they are. Drawn when it changes.

import { mix, onScale, scaleStyle, style } from "./palette.js";
import { diamond, segment, square, Stamp, word } from "./shapes.js";
import { shareOf } from "./marks.js";

const NUMBERED = 8; // radius of a node, in pixels, from which on there is room for its number

/** The edges that nobody can pass: their ends are not level (paper Section 3.3), or the edge has been taken away. */
export function isBlocked(run, { surface, taken }, edge) {
  const { a, b, rise } = run.edges;
  return taken[edge] === 1 || Math.abs(surface[b[edge]] - surface[a[edge]] - rise[edge]) >= run.reach - 1e-5;
}

/** Nodes and holes, with what lies on them and in them. */
export function drawMarks(pen, view) {
  const place = onScreen(view);
  const shown = sharesShown(view);
  drawTrails(pen, view, place, shown);
  drawBlocked(pen, view, place);
  drawNodes(pen, view, place, shown);
  drawHoles(pen, view, place, shown);
  drawGoal(pen, view, place);
  if (view.dot > NUMBERED) drawNumbers(pen, view, place, shown);
}

/** A place from far away: its holes, with a box's colour in the middle of those that are full, and the goal. */
export function drawFarMarks(pen, { run, camera, colours, replay, dot }) {
  const half = Math.max(1.5 * dot, 1);
  const { x, y } = run.nodes;
  for (const [node, , rim] of run.holes) {
    const middle = (size) => pen.fillRect(camera.screenX(x[node]) - size, camera.screenY(y[node]) - size, 2 * size, 2 * size);
    pen.fillStyle = colours.css.hole;
    middle(half);
    pen.fillStyle = sunken(colours);
    if (replay.surface[node] > rim - run.reach) middle(0.55 * half);
  }
  diamond(pen, camera.screenX(x[replay.goal]), camera.screenY(y[replay.goal]), Math.max(2.6 * dot, 6), colours.css.goal, colours.css.card, 1.5);
}

/** The colour of a box in a hole, in the shade of the pit: no box that can be pushed. */
const sunken = ({ box, hole }) => style(mix(box, hole, 0.4));

function onScreen({ run, camera }) {
  const xs = Float32Array.from(run.nodes.x, (x) => camera.screenX(x));
  const ys = Float32Array.from(run.nodes.y, (y) => camera.screenY(y));
  const seen = (i, room) => xs[i] > -room && ys[i] > -room && xs[i] < camera.width + room && ys[i] < camera.height + room;
  return { xs, ys, seen };
}

/** Node -> where its value lies on the scale of the shown pheromone, 0 to 1. */
function sharesShown({ layer, replay }) {
  const shown = new Map();
  layer?.nodes.forEach((node, i) => {
    const value = replay.values[layer.slots[i]];
    if (!Number.isNaN(value)) shown.set(node, shareOf(layer, value));
  });
  return shown;
}

/** Edges; those that climb are dashed. */
export function drawEdges(pen, view) {
  const { run, colours, unit, dot, replay } = view;
  const { xs, ys, seen } = onScreen(view);
  const { a, b, rise } = run.edges;
  const paths = { flat: new Path2D(), slope: new Path2D(), arrow: new Path2D() };
  for (let e = 0; e < a.length; e++) {
    if (replay.taken[e] || (!seen(a[e], unit) && !seen(b[e], unit))) continue;
    const [x0, y0, x1, y1] = [xs[a[e]], ys[a[e]], xs[b[e]], ys[b[e]]];
    segment(rise[e] ? paths.slope : paths.flat, x0, y0, x1, y1);
    if (rise[e] && dot > 5) { // an arrow points uphill
      const way = Math.atan2(y1 - y0, x1 - x0) + (rise[e] > 0 ? 0 : Math.PI), size = 0.5 * dot;
      const x = (x0 + x1) / 2, y = (y0 + y1) / 2;
      for (const side of [2.5, -2.5]) segment(paths.arrow, x, y, x + size * Math.cos(way + side), y + size * Math.sin(way + side));
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
}

/** A bar, as at a gate, across each edge that nobody can pass. */
function drawBlocked(pen, { run, colours, unit, dot, replay }, { xs, ys, seen }) {
  const { a, b } = run.edges;
  const half = Math.min(0.13 * unit, 11);
  pen.beginPath();
  for (let e = 0; e < a.length; e++) {
    if ((!seen(a[e], unit) && !seen(b[e], unit)) || !isBlocked(run, replay, e)) continue;
    const x = (xs[a[e]] + xs[b[e]]) / 2, y = (ys[a[e]] + ys[b[e]]) / 2;
    const angle = Math.atan2(ys[b[e]] - ys[a[e]], xs[b[e]] - xs[a[e]]);
    segment(pen, x - half * Math.sin(angle), y + half * Math.cos(angle), x + half * Math.sin(angle), y - half * Math.cos(angle));
  }
  pen.strokeStyle = colours.css.blocked;
  pen.lineWidth = dot > 5 ? 3 : 1.5;
  pen.lineCap = "round";
  pen.stroke();
  pen.lineCap = "butt";
}

/** The edges between marked nodes, the stronger the weaker of their marks the broader. */
function drawTrails(pen, { run, unit, layer }, { xs, ys, seen }, shown) {
  if (layer?.by === "box") return; // its values stand on holes, and lead nowhere
  const { a, b } = run.edges;
  const paths = new Map(); // 64 steps of the scale, each with one path
  for (let e = 0; e < a.length; e++) {
    if (!shown.has(a[e]) || !shown.has(b[e]) || (!seen(a[e], unit) && !seen(b[e], unit))) continue;
    const step = Math.round(63 * Math.min(Math.max(Math.min(shown.get(a[e]), shown.get(b[e])), 0), 1));
    if (!paths.has(step)) paths.set(step, new Path2D());
    segment(paths.get(step), xs[a[e]], ys[a[e]], xs[b[e]], ys[b[e]]);
  }
  pen.lineCap = "round";
  for (const step of [...paths.keys()].sort((one, other) => one - other)) {
    pen.strokeStyle = scaleStyle(step / 63);
    pen.lineWidth = 1 + Math.min(0.11 * unit, 12) * (step / 63) ** 2;
    pen.stroke(paths.get(step));
  }
  pen.lineCap = "butt";
}

function drawNodes(pen, { run, colours, dot }, { xs, ys, seen }, shown) {
  const { css } = colours;
  const holes = new Set(run.holes.map(([node]) => node));
  const ratio = window.devicePixelRatio || 1;
  const bare = new Stamp(Math.max(0.26 * dot, 1.2), null, 0, ratio);
  const marked = new Stamp(Math.max(0.4 * dot, 1.6), css.card, Math.min(1.2, 0.1 * dot), ratio);
  for (let i = 0; i < xs.length; i++) {
    if (!seen(i, dot) || holes.has(i)) continue;
    // On 64 steps of the scale, each of which is painted once.
    if (shown.has(i)) marked.draw(pen, xs[i], ys[i], scaleStyle(Math.round(63 * shown.get(i)) / 63));
    else bare.draw(pen, xs[i], ys[i], css["node-line"]);
  }
}

function drawGoal(pen, { colours, dot, replay }, { xs, ys }) {
  const { css } = colours;
  const [x, y] = [xs[replay.goal], ys[replay.goal]];
  if (dot <= 5) {
    diamond(pen, x, y, dot + 4, css.goal, css.card, 1);
    return;
  }
  pen.globalAlpha = 0.18;
  diamond(pen, x, y, 1.75 * dot, css.goal);
  pen.globalAlpha = 1;
  diamond(pen, x, y, 1.75 * dot, null, css.goal, Math.max(2, dot / 5));
}

/** Numbers of nodes stand beside them, where there is most room between the edges: whatever is on a node hides none. */
function drawNumbers(pen, view, { xs, ys, seen }, shown) {
  const { run, colours, dot, sizes, numberAt, land, replay } = view;
  const holes = new Set(run.holes.map(([node]) => node));
  const size = Math.min(0.62 * dot, 10.5);
  for (let i = 0; i < xs.length; i++) {
    if (!seen(i, 3 * dot)) continue;
    const number = String(run.nodes.id[i]);
    const sign = holes.has(i) ? 1.3 * sizes.hole : i === replay.goal ? 1.6 * dot : 1.15 * sizes.agent;
    const away = sign + 0.75 * size;
    const aside = 0.25 * size * (number.length - 1);
    const x = xs[i] + (away + aside) * Math.cos(numberAt[i]), y = ys[i] - away * Math.sin(numberAt[i]);
    const heat = view.layer?.by !== "box" && shown.has(i);
    const ground = heat ? scaleStyle(shown.get(i)) : style(mix(colours["land-low"], colours["land-high"], land.shares[i]));
    word(pen, number, x, y, size, heat ? onScale(shown.get(i)) : colours.css.quiet, ground, 500);
  }
}

/** A hole is a dark square; the boxes in it lie in it as they do in the pit, one above the other. */
function drawHoles(pen, { run, colours, replay, sizes }, { xs, ys, seen }, shown) {
  const { css } = colours;
  const half = sizes.hole;
  const sunk = sunken(colours);
  for (const [node, floor, rim] of run.holes) {
    if (!seen(node, half)) continue;
    const [x, y] = [xs[node], ys[node]];
    square(pen, x, y, half, css.hole, css["hole-line"], half > 8 ? 2 : 1);
    const room = half > 8 ? 2 : 1;
    let bottom = y + half - room;
    for (const box of replay.stacks.get(node) ?? []) {
      const high = Math.min((2 * (half - room) * run.boxes.height[box]) / (rim - floor), bottom - (y - half + room));
      if (!replay.seated(box) || high <= 0) continue;
      pen.fillStyle = sunk;
      pen.fillRect(x - half + room, bottom - high, 2 * (half - room), high);
      bottom -= high;
      pen.fillStyle = css["box-line"];
      if (half > 8) pen.fillRect(x - half + room, bottom, 2 * (half - room), 1.5);
    }
    if (shown.has(node)) square(pen, x, y, half + 2.5, null, scaleStyle(shown.get(node)), half > 8 ? 4 : 2);
    const fill = Math.round((100 * (replay.surface[node] - floor)) / (rim - floor));
    if (half > 10) word(pen, `${fill}%`, x, y, Math.min(0.55 * half, 11), "#ffffff", "#10131a");
  }
}
