// Puts the page together: the clock, the controls, and what is shown.

import { watchPointers } from "./camera.js";
import { drawResults, drawScale, drawTicks, episodeAt } from "./charts.js";
import { isBlocked } from "./ground.js";
import { fillHelp, watchKeys } from "./keys.js";
import { MapView } from "./map.js";
import { keyOf, layerOf, noteOf, titleOf } from "./marks.js";
import { readColours } from "./palette.js";
import { describe, EventList, fill, make, nextEvent, seconds, showAgent } from "./panels.js";
import { Replay } from "./replay.js";
import { SceneView } from "./scene.js";

const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 5, 10, 20, 50, 100, 500];
const EPISODE_SECONDS = 25; // how long an episode takes unless another speed is chosen
const WORDS_PAUSE = 150; // milliseconds between two updates of what is written
const BETWEEN = 700; // milliseconds from an episode's end to the next one
const CATCH_UP = 500; // milliseconds in which the distance to a run under way shrinks to a third

const byId = (id) => document.getElementById(id);

class Page {
  constructor(run) {
    this.run = run;
    this.replay = new Replay(run);
    this.map = new MapView(run, this.replay, byId("ground"), byId("things"));
    this.view = this.map;
    this.agent = -1;
    this.playing = this.following = false;
    this.field = null;
    this.keys = { hole: run.holes[0]?.[0] ?? -1, box: 0 };
    this.list = new EventList(byId("events"), run, this.replay, (row) => this.stepTo(row));
    this.name();
    this.fillControls();
    this.listen();
    this.themed();
    this.openEpisode(run.live ? run.episodes.length - 1 : 0);
    requestAnimationFrame((now) => this.frame(now));
  }

  name() {
    const { run } = this;
    const variant = run.variant ? ` ${run.variant}` : "";
    const part = run.of > run.episodes.length ? `${run.episodes.length} of ${run.of} episodes` : null;
    byId("name").textContent = `${run.name}${variant}`;
    document.title = `${run.name}${variant} · colonysim`;
    byId("what").textContent = [
      run.description, run.backend, run.policy, run.mode, `seed ${run.seed}`, part, run.status === "finished" ? null : run.status,
    ].filter(Boolean).join(" · ");
    byId("what").title = run.hash ? `trace ${run.hash}` : "";
  }

  fillControls() {
    const { run } = this;
    this.fillEpisodes();
    this.fillLayers();
    const longest = run.episodes.reduce((most, episode) => Math.max(most, episode[4]), 0);
    const suits = (speed) => longest / speed <= 1.6 * EPISODE_SECONDS;
    const speeds = [...SPEEDS];
    while (!suits(speeds.at(-1))) speeds.push(speeds.at(-1) * 10); // episodes of days and years
    fill(byId("speed"), speeds.map((speed) => [speed, `${speed}×`]));
    byId("speed").value = speeds.find(suits);
    if (run.live) byId("speed").value = 5; // nobody knows yet how long an episode will be
    byId("agent").max = run.agents.node.length - 1;
    byId("views").hidden = !run.bodies;
    byId("live").hidden = !run.live;
    drawScale(byId("legend-bar"));
    fillHelp();
  }

  fillEpisodes() {
    const select = byId("episode");
    const reached = (success) => (success < 1 ? ` (${Math.round(100 * success)} %)` : "");
    this.run.episodes.forEach(([number, , success, ended], i) => {
      const text = `Episode ${number}${ended ? reached(success) : " …"}`;
      const option = select.options[i] ?? select.appendChild(make("option", { value: i }));
      if (option.textContent !== text) option.textContent = text;
    });
  }

  fillLayers() {
    const { run } = this;
    const order = ["D", "H", "B", "E"];
    const fields = [...run.fields].sort((a, b) => (order.indexOf(a) + 9) % 9 - (order.indexOf(b) + 9) % 9);
    byId("layers").replaceChildren(...[null, ...fields].map((field) => {
      const title = field ? titleOf(field) : "No pheromone";
      return make("button", { "data-field": field ?? "", title, "aria-pressed": String(field === this.field) }, field ?? "none");
    }));
  }

  listen() {
    const things = byId("things");
    watchPointers(things, {
      drag: (dx, dy, second) => this.view === this.map ? this.map.camera.drag(dx, dy) : this.view.drag(dx, dy, second),
      zoom: (factor, x, y) => this.zoom(factor, x, y),
      click: (x, y) => this.click(x, y),
    });
    byId("play").addEventListener("click", () => this.play(!this.playing));
    byId("back").addEventListener("click", () => this.stepTo(nextEvent(this.run, this.replay, -1)));
    byId("on").addEventListener("click", () => this.stepTo(nextEvent(this.run, this.replay, 1)));
    byId("time").addEventListener("input", ({ target }) => this.seek(Number(target.value)));
    byId("live").addEventListener("click", () => this.follow(!this.following));
    byId("speed").addEventListener("change", () => this.follow(false));
    byId("episode").addEventListener("change", ({ target }) => this.chooseEpisode(Number(target.value)));
    byId("agent").addEventListener("change", ({ target }) => {
      this.choose(target.value !== "" && target.checkValidity() ? Number(target.value) : -1);
    });
    byId("key-choice").addEventListener("change", ({ target }) => this.chooseKey(Number(target.value)));
    byId("own").addEventListener("change", () => this.choose(this.agent));
    byId("layers").addEventListener("click", ({ target: { dataset } }) => {
      if (dataset.field !== undefined) this.showField(dataset.field || null);
    });
    byId("views").addEventListener("click", ({ target }) => target.dataset.view && this.show(target.dataset.view));
    byId("zoom").addEventListener("click", ({ target }) => this.zoomBy(target.dataset.zoom));
    byId("theme").addEventListener("click", () => this.switchTheme());
    byId("ask").addEventListener("click", () => byId("help").showModal());
    byId("results").addEventListener("click", (event) => this.chooseEpisode(episodeAt(event.target, this.run, event.offsetX)));
    watchKeys(this);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.themed());
    new ResizeObserver(() => this.resized()).observe(byId("sight"));
  }

  // -- time ------------------------------------------------------------------------------------------------------

  chooseEpisode(index) {
    this.follow(false);
    this.openEpisode(index);
  }

  openEpisode(index) {
    const { run } = this;
    if (!(index >= 0 && index < run.episodes.length)) return;
    this.replay.open(index);
    byId("episode").value = index;
    this.ended = 0;
    this.sum();
    this.write();
  }

  /** What is known of the shown episode as a whole. */
  sum() {
    const { run, replay } = this;
    byId("time").max = replay.duration;
    const [number, steps, success, ended, simulated] = run.episodes[replay.episode];
    const how = ended ? `ended with ${ended} after ${simulated.toFixed(1)} s` : `under way for ${simulated.toFixed(1)} s`;
    byId("result").textContent = `Episode ${number}: ${steps} steps, success ${success.toFixed(2)}, ${how}`;
    byId("results").setAttribute("aria-label", `Steps (bars) and success (dots) by episode. ${byId("result").textContent}`);
    drawResults(byId("results"), run, replay.episode, this.colours);
    drawTicks(byId("ticks"), run, replay, this.colours);
  }

  play(playing) {
    if (playing && !this.following && this.replay.time >= this.replay.duration) this.openEpisode((this.replay.episode + 1) % this.run.episodes.length);
    this.playing = playing;
    if (!playing) this.follow(false);
    byId("play").classList.toggle("going", playing);
    byId("play").setAttribute("aria-label", playing ? "Pause" : "Play");
    this.write();
  }

  seek(time) {
    this.follow(false);
    this.replay.seek(time);
    this.write();
  }

  stepTo(row) {
    this.play(false);
    if (row < this.replay.first) return;
    this.replay.seekEvent(row);
    this.write();
    byId("told").textContent = byId("caption").textContent;
  }

  frame(now) {
    const passed = Math.min(now - (this.last ?? now), 250);
    this.last = now;
    if (this.playing) this.advance(passed, now);
    const state = this.state();
    if (state !== this.drawn || this.view.late) {
      this.drawn = state;
      this.draw(now);
    }
    if (now - (this.written ?? 0) > WORDS_PAUSE && this.playing) {
      this.written = now;
      this.write();
    }
    if (!this.frames) performance.mark("first frame");
    this.frames = (this.frames ?? 0) + 1;
    requestAnimationFrame((next) => this.frame(next));
  }

  advance(passed, now) {
    const { replay } = this;
    if (this.following) {
      this.keepUp(passed);
      return;
    }
    if (replay.time < replay.duration) {
      this.replay.seek(replay.time + passed * Number(byId("speed").value));
      return;
    }
    if (!this.run.episodes[replay.episode][3] && this.run.status === "running") return; // there will be more
    this.ended ||= now;
    if (now - this.ended < BETWEEN) return;
    if (replay.episode + 1 < this.run.episodes.length) this.openEpisode(replay.episode + 1);
    else this.play(false);
  }

  // -- a run under way -------------------------------------------------------------------------------------------

  /** Whether to stay with the newest there is; whatever else is asked for ends it. */
  follow(following) {
    const begins = following && !this.following;
    this.following = following;
    if (begins) this.play(true);
    byId("live").setAttribute("aria-pressed", String(following));
  }

  /** Nears the newest moment whose actions are known: what somebody does is in the run once it is done. */
  keepUp(passed) {
    const { run, replay } = this;
    const newest = run.episodes.length - 1;
    const ended = run.episodes[replay.episode][3] || run.status !== "running";
    const to = ended ? replay.duration : Math.max(replay.duration - replay.longest, 0);
    if (replay.episode < newest - 1 || (ended && replay.episode < newest && replay.time >= to)) this.openEpisode(newest);
    else if (replay.time < to) replay.seek(Math.min(to, replay.time + Math.max(passed, (to - replay.time) * (1 - Math.exp(-passed / CATCH_UP)))));
    else if (run.status !== "running") this.play(false);
  }

  /** Takes note of what has been added to the run. */
  grown() {
    const { run, replay } = this;
    replay.grown();
    this.fillEpisodes();
    if (byId("layers").children.length !== run.fields.length + 1) this.fillLayers();
    byId("views").hidden = !run.bodies;
    if (this.field) this.readLayer();
    this.name();
    this.sum();
    this.write();
  }

  /** Says how it stands with the run itself. */
  tell(text, over) {
    const state = byId("state");
    state.hidden = false;
    if (state.textContent !== text) state.textContent = text;
    byId("live").hidden = over;
  }

  // -- what is shown ---------------------------------------------------------------------------------------------

  /** What the picture depends on: while it stays the same nothing is drawn. */
  state() {
    const { replay, view } = this;
    const layer = [this.layer?.field, this.layer?.key];
    return [replay.episode, replay.time, replay.cursor, this.agent, ...layer, this.theme, view.version, view === this.map].join();
  }

  draw(now) {
    this.view.decision = this.agent >= 0 ? this.lastDecision() : null;
    if (this.view === this.map) this.map.draw(now);
    else this.view.draw(this.map.clear());
  }

  lastDecision() {
    const key = [this.replay.episode, this.agent, this.replay.time].join();
    if (key !== this.decidedAt) [this.decidedAt, this.decided] = [key, this.replay.decisionOf(this.agent)];
    return this.decided;
  }

  /** Brings everything that is written up to date. */
  write() {
    const { run, replay } = this;
    byId("time").value = replay.time;
    byId("time").setAttribute("aria-valuetext", `${seconds(replay.time)} of ${seconds(replay.duration)}`);
    byId("clock").textContent = `${seconds(replay.time)} / ${seconds(replay.duration)}`;
    const row = Math.max(replay.cursor - 1, replay.first);
    byId("caption").textContent = row < replay.last ? describe(run, row).text : "";
    byId("things").setAttribute("aria-label", `The place at ${seconds(replay.time)}: ${byId("caption").textContent}`);
    showAgent(byId("chosen"), run, replay, this.agent, this.agent >= 0 ? this.lastDecision() : null);
    this.list.show(this.playing);
  }

  show(name) {
    if (name === "solid" && !this.scene) {
      try {
        this.scene = new SceneView(this.run, this.replay, byId("solid"), this.map);
      } catch (error) {
        byId("trouble").textContent = `3D needs WebGL 2, which this browser does not offer (${error.message}).`;
        byId("trouble").hidden = false;
        setTimeout(() => { byId("trouble").hidden = true; }, 6000);
        return;
      }
    }
    this.view = name === "solid" ? this.scene : this.map;
    byId("solid").hidden = name !== "solid";
    byId("ground").hidden = name === "solid";
    press(byId("views"), "view", name);
    this.apply();
    this.map.resize();
  }

  showField(field) {
    this.field = field;
    const { run } = this;
    const by = field && keyOf(run, field);
    byId("key").hidden = !by;
    if (by) {
      byId("key-name").textContent = by === "hole" ? "of hole" : "of box";
      const holes = run.holes.map(([node]) => [node, run.nodes.id[node]]);
      fill(byId("key-choice"), by === "hole" ? holes : Array.from(run.boxes.node, (_, box) => [box, box]));
      byId("key-choice").value = this.keys[by];
    }
    byId("layer-note").textContent = field ? noteOf(field) : "Marks on the ground; keys 1 to 5.";
    byId("legend").hidden = !field;
    if (field) {
      const of = by && `${by} ${by === "hole" ? run.nodes.id[this.keys.hole] : this.keys.box}`;
      byId("legend-name").textContent = by ? `${field}, ${of}` : titleOf(field);
    }
    press(byId("layers"), "field", field ?? "");
    this.readLayer();
  }

  /** The values of the shown pheromone, and their scale. */
  readLayer() {
    const { run, field } = this;
    const by = field && keyOf(run, field);
    this.layer = field ? layerOf(run, field, by ? this.keys[by] : -1) : null;
    if (field) {
      byId("legend-low").textContent = Number(this.layer.low.toPrecision(3));
      byId("legend-high").textContent = Number(this.layer.high.toPrecision(3));
    }
    this.apply();
  }

  chooseKey(key) {
    this.keys[keyOf(this.run, this.field)] = key;
    this.showField(this.field);
  }

  choose(agent) {
    this.agent = agent;
    byId("agent").value = agent < 0 ? "" : agent;
    this.list.only = byId("own").checked ? agent : -1;
    this.apply();
    this.write();
  }

  click(x, y) {
    const found = this.view.find(x, y);
    const by = this.field && keyOf(this.run, this.field);
    if (by === "hole" && found.hole !== undefined) this.chooseKey(found.hole);
    else if (by === "box" && found.box !== undefined && found.agent === undefined) this.chooseKey(found.box);
    else this.choose(found.agent ?? -1);
  }

  apply() {
    for (const view of [this.map, this.scene]) {
      if (view) Object.assign(view, { layer: this.layer ?? null, agent: this.agent, colours: this.colours, theme: this.theme });
    }
  }

  themed() {
    this.colours = readColours();
    this.theme = this.colours.css.paper;
    this.apply();
    drawResults(byId("results"), this.run, this.replay.episode, this.colours);
    drawTicks(byId("ticks"), this.run, this.replay, this.colours);
  }

  switchTheme() {
    const root = document.documentElement;
    const dark = root.style.colorScheme ? root.style.colorScheme === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
    root.style.colorScheme = dark ? "light" : "dark";
    this.themed();
  }

  resized() {
    this.map.resize();
    this.scene?.resize();
    this.themed(); // the small pictures too have a new size
  }

  zoom(factor, x, y) {
    if (this.view === this.map) this.map.camera.zoom(factor, x, y);
    else this.scene.zoom(factor);
  }

  zoomBy(word) {
    if (word === "fit") (this.view === this.map ? this.map.camera : this.scene).fit();
    else if (word) this.zoom(word === "in" ? 1.4 : 1 / 1.4);
  }
}

function press(group, name, value) {
  for (const button of group.querySelectorAll("button")) button.setAttribute("aria-pressed", String(button.dataset[name] === value));
}

/** Shows a run. */
export function start(run) {
  const page = new Page(run);
  page.showField(null);
  page.choose(-1);
  if (run.live) page.follow(true);
  // For tests, benchmarks and the curious, who drive the page from outside.
  window.colonysim = Object.assign(page, { isBlocked });
  return page;
}
