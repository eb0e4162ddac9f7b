// Small pictures: steps and success by episode, the events of an episode as ticks, the legend of a layer.

import { scaleStyle } from "./palette.js";
import { disc, sharpen } from "./shapes.js";

const LEFT = 26, TOP = 14, BOTTOM = 14;

/** Steps as bars, success as dots above; the shown episode stands out. */
export function drawResults(canvas, run, shown, colours) {
  const { pen, width, height } = sharpen(canvas);
  const { css } = colours;
  pen.clearRect(0, 0, width, height);
  const most = run.episodes.reduce((high, episode) => Math.max(high, episode[1]), 1);
  const each = (width - LEFT) / run.episodes.length;
  const room = height - TOP - BOTTOM;
  pen.font = "10px system-ui, sans-serif";
  pen.textBaseline = "middle";
  pen.textAlign = "right";
  pen.fillStyle = css.quiet;
  pen.fillText(most, LEFT - 5, TOP + 4);
  pen.fillText("0", LEFT - 5, height - BOTTOM - 3);
  pen.strokeStyle = css.line;
  pen.lineWidth = 1;
  for (const y of [TOP, height - BOTTOM]) {
    pen.beginPath();
    pen.moveTo(LEFT, y + 0.5);
    pen.lineTo(width, y + 0.5);
    pen.stroke();
  }
  run.episodes.forEach(([, steps, success], i) => {
    const high = Math.max(1, (room * steps) / most);
    const bar = Math.max(1, Math.min(each - 1.5, 26));
    pen.fillStyle = i === shown ? css.accent : css.way;
    pen.fillRect(LEFT + (i + 0.5) * each - bar / 2, height - BOTTOM - high, bar, high);
    if (each > 3 || success < 1) disc(pen, LEFT + (i + 0.5) * each, 6, Math.min(3, each / 2.4), success === 1 ? css.goal : css.blocked);
  });
  pen.textAlign = "left";
  pen.fillStyle = css.quiet;
  pen.fillText(run.episodes[0][0], LEFT, height - 5);
  pen.textAlign = "right";
  pen.fillText(run.episodes.at(-1)[0], width, height - 5);
}

/** Which episode a point of that picture belongs to. */
export function episodeAt(canvas, run, x) {
  const at = Math.floor(((x - LEFT) / (canvas.clientWidth - LEFT)) * run.episodes.length);
  return Math.min(Math.max(at, 0), run.episodes.length - 1);
}

/** A stroke for each push, arrival at the goal and failure of an episode, along its time; the rarer stand out. */
export function drawTicks(canvas, run, replay, colours) {
  const { pen, width, height } = sharpen(canvas);
  const { css } = colours;
  const { events } = run;
  pen.clearRect(0, 0, width, height);
  const strokes = { box: [], goal: [], blocked: [] };
  for (let row = replay.first; row < replay.last; row++) {
    const kind = run["words.kind"][events.kind[row]];
    const failed = events.kind[row] === replay.END && events.status[row] !== replay.ARRIVED;
    if (kind === "goal") strokes.goal.push(row);
    else if (kind === "lost" || kind === "spent" || failed) strokes.blocked.push(row);
    else if (events.kind[row] === replay.END && events.action[row] === replay.PUSH) strokes.box.push(row);
  }
  for (const [name, rows] of Object.entries(strokes)) {
    const wide = rows.length > width / 6 ? 1 : 2;
    pen.fillStyle = css[name];
    const top = name === "box" ? 0.5 * height : 0;
    for (const row of rows) pen.fillRect((width * events.time[row]) / replay.duration - wide / 2, top, wide, height - top);
  }
}

export function drawScale(canvas) {
  const pen = canvas.getContext("2d");
  for (let x = 0; x < canvas.width; x++) {
    pen.fillStyle = scaleStyle(x / (canvas.width - 1));
    pen.fillRect(x, 0, 1, canvas.height);
  }
}
