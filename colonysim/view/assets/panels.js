// Everything beside the picture that is made of words. Text of a run only ever becomes textContent, never markup.

import { percent } from "./things.js";

/** A new element with attributes, text and children. */
export function make(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value !== null && value !== undefined && value !== false) element.setAttribute(name, value === true ? "" : value);
  }
  element.append(...children.map((child) => (child instanceof Node ? child : String(child))));
  return element;
}

/** The options of a select: pairs of value and text. */
export const fill = (select, options) => select.replaceChildren(...options.map(([value, text]) => make("option", { value }, text)));

export const seconds = (milliseconds) => `${(milliseconds / 1000).toFixed(1)} s`;

/** An event in words: what happened, and whether it went wrong. */
export function describe(run, row) {
  const { events, nodes } = run;
  const said = (column) => run[`words.${column}`][events[column][row]];
  const id = (column) => nodes.id[events[column][row]];
  const who = `agent ${events.agent[row]}`;
  const reason = said("reason") ? ` (${said("reason")})` : "";
  switch (said("kind")) {
    case "start": return { text: `${who} starts at ${id("node")}` };
    case "goal": return { text: `${who} is at the goal`, good: true };
    case "spent": return { text: `${who} has used up its steps at ${id("node")}`, bad: true };
    case "lost": return { text: `${who} is lost at ${id("node")}`, bad: true };
    case "wait": return said("reason") === "stopped" ? { text: `${who} stands still at ${id("node")}`, bad: true } : { text: `${who} waits at ${id("node")}${events.target[row] >= 0 ? ` for ${id("target")}` : ""}` };
    case "change": return { text: changeOf(run, row) };
    case "episode": return { text: `episode ends: ${said("status")}` };
    default: {
      const bad = said("status") !== "arrived";
      const box = `box ${events.box[row]}`;
      const done = {
        travel: `travels ${id("node")} → ${id("target")}`,
        take: `takes ${box} at ${id("target")}`,
        push: `pushes ${box}: ${id("node")} → ${id("target")}`,
      }[said("action")] ?? said("action");
      return { text: `${who} ${done}${bad ? `: ${said("status")}${reason}` : ""}`, bad };
    }
  }
}

/** A change of the scenario's timeline in words. */
function changeOf(run, row) {
  const { events, nodes } = run;
  const [node, target] = [nodes.id[events.node[row]], nodes.id[events.target[row]]];
  const box = `box ${events.box[row]}`;
  const hand = run.later.byHand.includes(events.step[row]) ? "by hand: " : "";
  return hand + {
    add_edge: `edge ${node} – ${target} comes`,
    remove_edge: `edge ${node} – ${target} goes`,
    set_surface: `the surface of ${node} changes`,
    add_box: `${box} appears at ${node}`,
    remove_box: `${box} disappears at ${node}`,
    move_goal: `the goal is ${node} now`,
    add_agent: `an agent joins at ${node}`,
    fail: `agent ${events.agent[row]} fails at ${node}`,
    wipe: "marks are wiped away",
    policy: run.later.tunings[events.step[row]],
  }[run["words.action"][events.action[row]]];
}

/** What the chosen agent is doing, and what it last chose from. */
export function showAgent(element, run, replay, agent, decision) {
  keepHeight(element, agent);
  if (agent < 0) {
    element.replaceChildren(make("p", { class: "note" }, "Click an agent to see what it decided and why."));
    return;
  }
  const { events, nodes } = run;
  const row = replay.action[agent];
  const node = nodes.id[replay.agentNode[agent]];
  let doing = `waits${replay.waitsFor[agent] >= 0 ? ` for ${nodes.id[replay.waitsFor[agent]]}` : ""}`;
  if (replay.state[agent]) doing = ["", "at the goal", "used up its steps", "lost", "not there yet"][replay.state[agent]];
  else if (row >= 0) {
    const box = events.box[row] >= 0 ? `box ${events.box[row]} ` : "";
    const verb = { travel: "travels", take: "goes to take", push: "pushes" }[run["words.action"][events.action[row]]] ?? "acts";
    doing = `${verb} ${box}to ${nodes.id[events.target[row]]}`;
  } else if (replay.stopped[agent]) doing = "stands still for a while";
  else if (replay.waitsFor[agent] < 0) doing = "decides";
  const facts = [["doing", doing], ["node", node]];
  if (row >= 0) facts.push(["reserved", nodes.id[events.target[row]]]);
  if (row >= 0 && events.hole[row] >= 0) facts.push(["meant for", `hole ${nodes.id[events.hole[row]]}`]);
  const list = make("dl", {}, ...facts.flatMap(([name, value]) => [make("dt", {}, name), make("dd", {}, value)]));
  element.replaceChildren(list, decisionTable(run, decision));
}

/** Of one and the same agent the table only ever grows, so that what stands below it does not jump while it plays. */
function keepHeight(element, agent) {
  const same = element.dataset.agent === String(agent);
  element.dataset.agent = agent;
  element.style.minHeight = same && agent >= 0 ? `${element.offsetHeight}px` : "";
}

function decisionTable(run, decision) {
  if (!decision) return make("p", { class: "note" }, "No decision recorded so far.");
  const { nodes } = run;
  const choices = [...decision.choices].sort((a, b) => b.chance - a.chance);
  // A box's way may begin with the same node as a travel: the row names the node only, the likelier is meant.
  const taken = choices.findIndex(({ target }) => target === decision.chosen);
  const rows = choices.map(({ target, box, chance }, i) => {
    const name = `${box >= 0 ? `box ${box} → ` : ""}${target >= 0 ? nodes.id[target] : "stay"}`;
    const meter = make("meter", { min: 0, max: 1, value: chance, "aria-label": `probability ${percent(chance)}` });
    return make("tr", { class: i === taken ? "taken" : null },
      make("td", {}, name, i === taken ? " ✓" : ""), make("td", {}, meter), make("td", {}, percent(chance)));
  });
  const how = decision.explored ? ", exploring" : "";
  const caption = make("caption", {}, `Last decision, at ${nodes.id[decision.node]}, ${seconds(decision.time)}${how}`);
  return make("table", {}, caption, make("tbody", {}, ...rows));
}

const AROUND = 60, AROUND_PLAYING = 12;

/** The events around the present one; `pick(row)` is called with the one that is clicked. */
export class EventList {
  constructor(element, run, replay, pick) {
    Object.assign(this, { element, run, replay });
    this.only = -1;
    element.addEventListener("click", ({ target }) => {
      const button = target.closest("button");
      if (button) pick(Number(button.dataset.row));
    });
  }

  show(playing) {
    const { replay } = this;
    const now = Math.max(replay.cursor - 1, replay.first);
    const key = [replay.episode, now, this.only, playing].join();
    if (key === this.shown) return;
    this.shown = key;
    const rows = this.around(now, playing ? AROUND_PLAYING : AROUND);
    const made = rows.map((row) => {
      const { text, bad } = describe(this.run, row);
      const time = make("time", {}, seconds(this.run.events.time[row]));
      return make("li", {}, make("button", { "data-row": row, "aria-current": row === now ? "true" : null, tabindex: row === now ? 0 : -1 },
        time, make("span", { class: bad ? "bad" : null }, text)));
    });
    this.element.replaceChildren(...made);
    const present = this.element.querySelector("[aria-current]") ?? this.element.children[this.before - 1];
    if (present) this.element.scrollTop = present.offsetTop - this.element.offsetTop - this.element.clientHeight / 2;
  }

  around(now, most) {
    const { replay, run } = this;
    const wanted = (row) => this.only < 0 || run.events.agent[row] === this.only;
    const earlier = [], later = [];
    for (let row = now; row >= replay.first && earlier.length < most; row--) if (wanted(row)) earlier.unshift(row);
    for (let row = now + 1; row < replay.last && later.length < most; row++) if (wanted(row)) later.push(row);
    this.before = earlier.length;
    return [...earlier, ...later];
  }
}

/** The row of the next event that is seen: `step` 1 onwards, -1 back. */
export function nextEvent(run, replay, step) {
  if (step > 0) return replay.cursor;
  const now = replay.cursor - 1;
  // Between two events, back means to the one before.
  return replay.time > run.events.time[Math.max(now, replay.first)] ? now : now - 1;
}

