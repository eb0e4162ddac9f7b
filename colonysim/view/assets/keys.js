// The keys, and the dialog that tells what they do and what the signs mean.

import { make, nextEvent } from "./panels.js";

const KEYS = [
  ["space", "play, pause"], ["← →", "step to the event before, the next one"], ["Page up, down", "episode before, next episode"],
  ["Home, End", "start, end of the episode"], ["s, S", "faster, slower"], ["1 to 5", "no pheromone, or one of them"],
  ["a, A", "choose the next agent, the one before; Escape: none"], ["+ − 0", "zoom in, out, show all"],
  ["v", "map or 3D (runs with rigid bodies)"], ["t", "light or dark"],
  ["l", "stay with a run under way, or not"],
];
const SIGNS = [
  ["pink disc, A2", "agent 2; a stroke: its steps are used up; a cross: lost; two bars: stands still"],
  ["blue square, B1", "box 1; higher up: stacked"], ["dot, 13", "node 13"],
  ["dark square", "hole, with the boxes in it and how full it is"], ["green diamond", "goal"],
  ["red bar", "edge that nobody can pass: too high a step"], ["dashed edge", "slope; the arrow points uphill"],
  ["dashed ring", "the node that an agent has reserved: where it is going"], ["dotted ring", "the node that a waiting agent waits for"],
  ["coloured ground", "the chosen pheromone; coloured edges: its trails, the broader the stronger"],
  ["clear circle", "what the chosen agent can see; lines: what it could choose, the likelier the broader"],
];

/** Writes the dialog. */
export function fillHelp() {
  for (const [id, pairs] of [["keys", KEYS], ["signs", SIGNS]]) {
    document.getElementById(id).replaceChildren(...pairs.flatMap(([name, text]) => [make("dt", {}, name), make("dd", {}, text)]));
  }
}

/** Has the keys drive the page. */
export function watchKeys(page) {
  document.addEventListener("keydown", (event) => {
    const { target } = event;
    if (event.ctrlKey || event.metaKey || event.altKey || document.getElementById("help").open) return;
    const name = event.key;
    if (target.type === "number" && name !== "Escape") return;
    if (target.tagName === "SELECT" || (target.tagName === "BUTTON" && (name === " " || name === "Enter"))) return;
    if (target.type === "checkbox" && name === " ") return;
    const act = meaning(page, name);
    if (!act) return;
    event.preventDefault();
    act();
  });
}

/** What a key does, or undefined. */
function meaning(page, name) {
  const { run, replay } = page;
  const speed = document.getElementById("speed");
  const faster = (by) => { speed.selectedIndex = Math.min(Math.max(speed.selectedIndex + by, 0), speed.length - 1); };
  const layer = (i) => {
    const button = document.getElementById("layers").children[i];
    if (button) page.showField(button.dataset.field || null);
  };
  const nextAgent = (by) => {
    const count = run.agents.node.length + 1;
    page.choose(((page.agent + 1 + by + count) % count) - 1);
  };
  return {
    " ": () => page.play(!page.playing),
    ArrowRight: () => page.stepTo(nextEvent(run, replay, 1)),
    ArrowLeft: () => page.stepTo(nextEvent(run, replay, -1)),
    PageDown: () => page.chooseEpisode(replay.episode + 1),
    PageUp: () => page.chooseEpisode(replay.episode - 1),
    Home: () => page.seek(0),
    End: () => page.seek(replay.duration),
    s: () => faster(1), S: () => faster(-1),
    a: () => nextAgent(1), A: () => nextAgent(-1),
    1: () => layer(0), 2: () => layer(1), 3: () => layer(2), 4: () => layer(3), 5: () => layer(4),
    "+": () => page.zoomBy("in"), "=": () => page.zoomBy("in"), "-": () => page.zoomBy("out"), 0: () => page.zoomBy("fit"),
    v: () => run.bodies && page.show(page.view === page.map ? "solid" : "map"),
    l: () => run.live && run.status === "running" && page.follow(!page.following),
    t: () => page.switchTheme(),
    "?": () => document.getElementById("help").showModal(),
    Escape: () => page.choose(-1),
  }[name];
}
