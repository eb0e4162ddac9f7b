// What moves: boxes and agents, with what an agent has reserved, waits for, sees and last decided. Drawn every frame.

import { LOST, SPENT } from "./replay.js";
import { agentLabel, boxLabel, disc, segment, square, Stamp, word, writeSign } from "./shapes.js";

export function drawThings(pen, view) {
  const chosen = view.agent;
  const active = chosen >= 0 && view.replay.present(chosen);
  if (active) drawSight(pen, view, chosen);
  if (view.layer?.by === "box") drawWorth(pen, view);
  if (view.dot > 4.5) drawReserved(pen, view);
  if (active) drawChoice(pen, view);
  drawBoxes(pen, view);
  drawAgents(pen, view);
  if (active && view.dot > 6) drawChances(pen, view);
}

/** The chosen agent and what it sees, where the others are but dots. */
export function drawChosen(pen, view) {
  const { agent, replay, camera, colours } = view;
  if (agent < 0 || !replay.present(agent)) return;
  drawSight(pen, view, agent);
  disc(pen, camera.screenX(replay.agentX[agent]), camera.screenY(replay.agentY[agent]), 7, null, colours.css.ink, 2.5);
}

const visible = ({ camera, unit }, x, y) => x > -unit && y > -unit && x < camera.width + unit && y < camera.height + unit;

/** What an agent can see: all within its radius. */
function drawSight(pen, { run, camera, colours, replay }, agent) {
  const node = replay.agentNode[agent];
  const x = camera.screenX(run.nodes.x[node]), y = camera.screenY(run.nodes.y[node]);
  const radius = (run.radii?.[agent] ?? run.radius) * camera.scale;
  pen.save();
  pen.globalAlpha = 0.3;
  pen.fillStyle = colours.css.sky;
  pen.beginPath();
  pen.rect(0, 0, camera.width, camera.height);
  pen.arc(x, y, radius, 0, 2 * Math.PI, true);
  pen.fill();
  pen.globalAlpha = 0.9;
  pen.setLineDash([2, 5]);
  disc(pen, x, y, radius, null, colours.css["agent-line"], 1.5);
  pen.restore();
}

/** A chosen box and its worth for each hole. */
function drawWorth(pen, { run, camera, colours, replay, layer }) {
  const x = camera.screenX(replay.boxX[layer.key]), y = camera.screenY(replay.boxY[layer.key]);
  layer.nodes.forEach((node, i) => {
    const value = replay.values[layer.slots[i]];
    if (Number.isNaN(value)) return;
    const hx = camera.screenX(run.nodes.x[node]), hy = camera.screenY(run.nodes.y[node]);
    pen.strokeStyle = colours.css["box-line"];
    pen.lineWidth = 2;
    pen.setLineDash([2, 4]);
    pen.beginPath();
    segment(pen, x, y, hx, hy);
    pen.stroke();
    pen.setLineDash([]);
    word(pen, value.toPrecision(3), (x + hx) / 2, (y + hy) / 2, 12, colours.css.ink, colours.css.card);
  });
}

function drawReserved(pen, view) {
  const { run, camera, colours, replay, dot, sizes } = view;
  const { nodes, events } = run;
  const ring = sizes.agent + Math.max(3, 0.25 * dot);
  const reserved = new Path2D(), waited = new Path2D();
  for (let agent = 0; agent < replay.action.length; agent++) {
    if (replay.state[agent]) continue;
    const row = replay.action[agent];
    const node = row >= 0 ? events.target[row] : replay.waitsFor[agent];
    if (node < 0) continue;
    const x = camera.screenX(nodes.x[node]), y = camera.screenY(nodes.y[node]);
    const ax = camera.screenX(replay.agentX[agent]), ay = camera.screenY(replay.agentY[agent]);
    if (!visible(view, x, y) && !visible(view, ax, ay)) continue;
    const path = row >= 0 ? reserved : waited;
    segment(path, ax, ay, x, y);
    path.moveTo(x + ring, y);
    path.arc(x, y, ring, 0, 2 * Math.PI);
  }
  pen.lineWidth = Math.min(Math.max(1.2, dot / 8), 1.8);
  pen.setLineDash([4, 3]);
  pen.strokeStyle = colours.css["agent-line"];
  pen.stroke(reserved);
  pen.setLineDash([1, 4]);
  pen.lineCap = "round";
  pen.strokeStyle = colours.css.waiting;
  pen.stroke(waited);
  pen.setLineDash([]);
  pen.lineCap = "butt";
}

function drawBoxes(pen, view) {
  const { camera, colours, replay, dot, layer, sizes } = view;
  const half = sizes.box;
  for (let box = 0; box < replay.boxX.length; box++) {
    if (replay.boxNode[box] < 0 || replay.seated(box)) continue; // the latter are drawn as what fills the hole
    const x = camera.screenX(replay.boxX[box]);
    const lift = replay.pushed[box] ? 0 : replay.above(box);
    const y = camera.screenY(replay.boxY[box]) - 0.55 * half * lift;
    if (!visible(view, x, y)) continue;
    square(pen, x, y, half, colours.css.box, colours.css["box-line"], Math.max(1, dot / 8));
    if (layer?.by === "box" && layer.key === box) square(pen, x, y, half + 3, null, colours.css.ink, 2);
    writeSign(pen, boxLabel(box), x, y, half, "#ffffff");
  }
}

function drawAgents(pen, view) {
  const { run, camera, colours, replay, dot, sizes, agent: chosen } = view;
  const { css } = colours;
  const radius = sizes.agent;
  const stamp = new Stamp(radius, css["agent-line"], Math.max(1, dot / 9));
  const labels = [];
  for (let agent = 0; agent < replay.agentX.length; agent++) {
    if (!replay.present(agent)) continue;
    let x = camera.screenX(replay.agentX[agent]), y = camera.screenY(replay.agentY[agent]);
    if (!visible(view, x, y)) continue;
    // Who shares a node with a box stands beside it.
    if (!run.bodies && (replay.stacks.has(replay.agentNode[agent]) || replay.action[agent] >= 0)) {
      x -= 1.05 * radius * beside(view, agent);
      y += 1.05 * radius * beside(view, agent);
    }
    stamp.draw(pen, x, y, css.agent);
    labels.push([agent, x, y]);
  }
  for (const [agent, x, y] of labels) {
    if (agent === chosen) disc(pen, x, y, radius + 4, null, css.ink, 2.5);
    if (replay.state[agent] === SPENT || replay.state[agent] === LOST) {
      pen.beginPath();
      segment(pen, x - radius, y - radius, x + radius, y + radius);
      if (replay.state[agent] === LOST) segment(pen, x + radius, y - radius, x - radius, y + radius);
      pen.strokeStyle = css.blocked;
      pen.lineWidth = 3;
      pen.stroke();
    }
    if (replay.stopped[agent] && !replay.state[agent] && replay.action[agent] < 0) {
      pen.beginPath();
      for (const side of [-1, 1]) segment(pen, x + 1.25 * radius * side, y - radius, x + 1.25 * radius * side, y + radius);
      pen.strokeStyle = css.blocked;
      pen.lineWidth = 3;
      pen.stroke();
    }
    writeSign(pen, agentLabel(agent), x, y, radius, "#101010");
  }
}

/** How far aside an agent stands, 0 to 1: all the way where a box is, and in between on the way there or from it. */
function beside({ run, replay }, agent) {
  const here = replay.stacks.has(replay.agentNode[agent]) ? 1 : 0;
  const row = replay.action[agent];
  if (row < 0) return here;
  const { events, "words.action": words } = run;
  const holds = events.box[row] >= 0 && words[events.action[row]] !== "travel";
  const there = holds || replay.stacks.has(events.target[row]) ? 1 : 0;
  const share = events.took[row] ? 1 - (events.time[row] - replay.time) / events.took[row] : 1;
  return here + (there - here) * Math.min(Math.max(share, 0), 1);
}

/** The last decision of the chosen agent: what it could choose, the likelier the broader. */
function drawChoice(pen, { run, camera, colours, dot, decision }) {
  if (!decision) return;
  const { x: xs, y: ys } = run.nodes;
  const x = camera.screenX(xs[decision.node]), y = camera.screenY(ys[decision.node]);
  for (const { target, chance } of decision.choices) {
    if (target < 0) continue;
    const tx = camera.screenX(xs[target]), ty = camera.screenY(ys[target]);
    pen.strokeStyle = colours.css["agent-line"];
    pen.globalAlpha = target === decision.chosen ? 0.95 : 0.55;
    pen.lineWidth = 1 + 0.45 * dot * chance;
    pen.beginPath();
    segment(pen, x, y, tx, ty);
    pen.stroke();
    pen.globalAlpha = 1;
  }
}

/** Its probabilities, each beside the way to its node and shortly before it. */
function drawChances(pen, { run, camera, colours, dot, decision }) {
  const { x: xs, y: ys } = run.nodes;
  for (const { target, chance } of decision?.choices ?? []) {
    if (target < 0 || chance < 0.005) continue;
    const tx = camera.screenX(xs[target]), ty = camera.screenY(ys[target]);
    const dx = camera.screenX(xs[decision.node]) - tx, dy = camera.screenY(ys[decision.node]) - ty;
    const long = Math.max(Math.hypot(dx, dy), 1), share = Math.min(0.5, (1.6 * dot + 14) / long);
    const side = (dx < 0 ? 13 : -13) / long; // above a way that leads to the east or the west
    word(pen, percent(chance), tx + share * dx - side * dy * 1.2, ty + share * dy + side * dx, 11, colours.css.ink, colours.css.card);
  }
}

export const percent = (chance) => (chance > 0 && chance < 0.005 ? "< 1 %" : `${Math.round(100 * chance)} %`);
