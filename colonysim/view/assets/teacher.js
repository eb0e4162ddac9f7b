// The teacher's panel on the page of a run under way: what is asked for here goes to the server that the page came from,
// and the run does it between two events. What it did stands in the trace.

import { fill, make } from "./panels.js";

const PACES = [0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500, 0]; // simulated seconds a second; 0: as many as may be
const LOOK = 700; // milliseconds between two looks at how it stands
const SETTLE = 150; // milliseconds for which a control has to rest before its value is sent
const EDITED = 3000; // milliseconds in which a value that was just set is not set back by an older one
const NEAR = 36; // pixels from a click to the node that is meant
// What most lessons move; everything else is one click away.
const FIRST = ["beta", "epsilon", "exploration_evaporation", "hole_evaporation", "distance_half_life", "exploration_half_life", "patience"];

const label = (pace) => (pace ? `${pace} simulated seconds a second` : "as fast as it goes");

export class Teacher {
  constructor(run, page) {
    Object.assign(this, { run, page, tool: null, group: "", edited: new Map(), controls: new Map(), wanted: new Map(), setting: false, state: { paused: false } });
    this.address = `controls?token=${encodeURIComponent(new URLSearchParams(location.search).get("token"))}`;
    this.build();
    this.listen();
    this.look();
  }

  // -- asking ----------------------------------------------------------------------------------------------------

  /** Sends a command; says what came of it. */
  async ask(command, done = "") {
    let answer, told;
    try {
      answer = await fetch(this.address, {
        method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(command), cache: "no-store",
      });
      told = await answer.json();
    } catch {
      this.say("no connection: colonysim has ended", true);
      return false;
    }
    if (!answer.ok) {
      this.say(told.error, true);
      return false;
    }
    this.take(told);
    if (done) this.say(done + (this.state.paused && command.do === "change" ? ", with the next event" : ""));
    return true;
  }

  /** Looks how it stands, again and again: there may be another page. */
  async look() {
    const fine = await this.ask({ do: "look" });
    setTimeout(() => this.look(), fine ? LOOK : 4 * LOOK);
  }

  change(item, done) {
    return this.ask({ do: "change", change: item }, done);
  }

  take(state) {
    if (state.run !== this.run.panel) {
      location.reload(); // the run has begun anew
      return;
    }
    const { paused } = this.state, first = !this.state.offers;
    this.state = state;
    if (first) this.fillGroups();
    this.write();
    if (state.paused && !paused) this.newest();
    if (!state.paused && paused) this.page.follow(true);
  }

  // -- what is there ---------------------------------------------------------------------------------------------

  build() {
    const button = (name, text, more = {}) => make("button", { type: "button", "data-do": name, ...more }, text);
    this.pause = button("pause", "Pause");
    this.step = button("step", "Step", { title: "On to the next event" });
    this.reset = button("reset", "Start anew", { title: "The run begins anew, in a directory of its own" });
    this.pace = make("input", { type: "range", id: "pace", min: 0, max: PACES.length - 1, step: 1 });
    this.paceLabel = make("output", { for: "pace" });
    this.drop = button("drop", "Drop a box", { "aria-pressed": "false" });
    this.kill = button("kill", "Kill a robot", { "aria-pressed": "false" });
    this.height = make("input", { type: "number", id: "drop-height", min: 0.01, step: "any" });
    this.heightLabel = make("label", {}, "height ", this.height);
    this.told = make("p", { class: "note", role: "status", id: "taught" });
    this.groups = make("select", { id: "whose" });
    this.groupsLabel = make("label", {}, "of ", this.groups);
    this.parameters = make("div", { class: "parameters" });
    this.more = make("div", { class: "parameters" });
    this.rest = make("details", {}, make("summary", {}, "All parameters"), this.more);
    this.policy = make("h3", {}, "Policy");
    this.made = make("ol", { class: "made" });
    this.repeat = make("code");
    this.record = make("details", {}, make("summary", {}, "Done by hand"), this.made,
      make("p", { class: "note" }, "Everything done by hand is in the trace. The run, with all of it, is repeated by "), this.repeat);
    this.section = make("section", { id: "teacher", "aria-labelledby": "teacher-title" },
      make("h2", { id: "teacher-title" }, "Teacher"),
      make("p", { class: "note" }, "These control the run itself; the bar below, what the page shows of it."),
      make("div", { class: "row" }, this.pause, this.step, this.reset),
      make("label", { class: "pace" }, "Speed ", this.pace, this.paceLabel),
      make("div", { class: "row" }, this.drop, this.kill, this.heightLabel),
      this.told,
      make("div", { class: "row" }, this.policy, this.groupsLabel),
      this.parameters, this.rest, this.record);
    document.querySelector("aside").prepend(this.section);
  }

  listen() {
    const { page } = this;
    this.section.addEventListener("click", ({ target }) => {
      const word = target.dataset.do;
      if (word === "pause") this.ask({ do: this.state.paused ? "go" : "pause" });
      else if (word === "step") this.ask({ do: "step" });
      else if (word === "reset") this.startAnew();
      else if (word) this.choose(this.tool === word ? null : word);
    });
    this.pace.addEventListener("input", () => { this.paceLabel.value = label(PACES[this.pace.value]); });
    this.pace.addEventListener("change", () => this.ask({ do: "pace", seconds: PACES[this.pace.value] }));
    this.groups.addEventListener("change", () => this.showGroup(this.groups.value));
    this.section.addEventListener("keydown", (event) => event.stopPropagation()); // the page's keys are not meant here
    document.addEventListener("keydown", ({ key }) => key === "Escape" && this.choose(null));
    const click = page.click.bind(page), grown = page.grown.bind(page);
    page.click = (x, y) => (this.tool ? this.use(x, y) : click(x, y));
    page.grown = () => {
      grown();
      if (this.state.paused) this.newest();
    };
    const tell = page.tell.bind(page);
    page.tell = (text, over) => tell(this.state.paused && !over ? "paused" : text, over);
  }

  startAnew() {
    if (confirm("Start the run anew? What it has recorded so far stays; the new one is recorded in a directory of its own.")) this.ask({ do: "reset" });
  }

  /** Shows the newest there is: of a run that is paused nothing more is to come. */
  newest() {
    const { page, run } = this;
    if (page.replay.episode !== run.episodes.length - 1) page.openEpisode(run.episodes.length - 1);
    page.play(false);
    page.seek(page.replay.duration);
  }

  // -- tools -----------------------------------------------------------------------------------------------------

  choose(tool) {
    if (tool && this.page.view !== this.page.map) this.page.show("map");
    this.tool = tool;
    for (const [name, button] of [["drop", this.drop], ["kill", this.kill]]) button.setAttribute("aria-pressed", String(name === tool));
    document.getElementById("things").style.cursor = tool ? "crosshair" : "";
    if (tool) this.say(tool === "drop" ? "Click a node: the box appears there once nobody is in the way." : "Click a robot: it is lost for the rest of the episode, and stays in the way.");
    else this.say("");
  }

  use(x, y) {
    if (this.tool === "kill") {
      const { agent } = this.page.map.find(x, y);
      if (agent === undefined) this.say("There is no robot here.", true);
      else this.change({ fail: { agents: [agent] } }, `Agent ${agent} fails`);
      return;
    }
    const node = this.nodeAt(x, y);
    if (node < 0) this.say("There is no node here.", true);
    else this.change({ add_box: { node: this.run.nodes.id[node], height: Number(this.height.value) } }, `A box comes down on ${this.run.nodes.id[node]}`);
  }

  nodeAt(px, py) {
    const { nodes } = this.run, { camera } = this.page.map;
    let found = -1, best = NEAR;
    for (let i = 0; i < nodes.x.length; i++) {
      const away = Math.hypot(camera.screenX(nodes.x[i]) - px, camera.screenY(nodes.y[i]) - py);
      if (away < best) [found, best] = [i, away];
    }
    return found;
  }

  // -- parameters ------------------------------------------------------------------------------------------------

  fillGroups() {
    fill(this.groups, this.state.offers.map(({ group }) => [group, group || "all agents"]));
    this.groupsLabel.hidden = this.state.offers.length < 2;
    this.height.value = Number(this.state.height.toPrecision(4));
    this.showGroup("");
  }

  offer() {
    return this.state.offers.find(({ group }) => group === this.group);
  }

  showGroup(group) {
    this.group = group;
    this.controls.clear();
    this.edited.clear();
    const { policy, parameters } = this.offer();
    this.policy.textContent = `Policy ${policy}`;
    const known = FIRST.filter((name) => parameters.some((each) => each.name === name));
    const first = known.length ? known : parameters.slice(0, FIRST.length).map(({ name }) => name);
    this.parameters.replaceChildren(...parameters.filter(({ name }) => first.includes(name)).map((each) => this.row(each)));
    this.more.replaceChildren(...parameters.filter(({ name }) => !first.includes(name)).map((each) => this.row(each)));
    this.rest.hidden = !this.more.children.length;
    if (!parameters.length) this.parameters.replaceChildren(make("p", { class: "note" }, "This policy has no parameters to set."));
    this.write();
  }

  row(parameter) {
    const { name, kind, meaning, paper, values } = parameter;
    const id = `set-${name}`;
    const control = { number: () => this.slider(parameter, id), flag: () => this.flag(name, id), word: () => this.words(parameter, id) }[kind]();
    const bounds = values ? ` (${values})` : "";
    return make("div", { class: "parameter", "data-name": name }, make("label", { for: id }, name), control,
      make("p", { class: "note" }, `${meaning}${bounds}${paper ? ` ${paper} of the paper.` : ""}`));
  }

  slider({ name, low, high, step, null: none }, id) {
    const range = make("input", { type: "range", min: low, max: high, step, "aria-label": `${name}, slider` });
    const exact = make("input", { type: "number", id, step: "any", placeholder: none ? "none" : null });
    const show = (value) => {
      exact.value = value ?? "";
      range.value = value ?? high;
      range.classList.toggle("none", value === null);
    };
    range.addEventListener("input", () => { this.touch(name); exact.value = range.value; range.classList.remove("none"); });
    range.addEventListener("change", () => this.set(name, Number(range.value)));
    exact.addEventListener("input", () => this.touch(name));
    exact.addEventListener("change", () => {
      if (exact.value !== "" && exact.checkValidity()) this.set(name, Number(exact.value));
      else if (exact.value === "" && none && exact.checkValidity()) this.set(name, null);
      else this.say(`${name}: expected a number`, true);
    });
    this.controls.set(name, show);
    return make("span", { class: "number" }, range, exact);
  }

  flag(name, id) {
    const box = make("input", { type: "checkbox", id });
    box.addEventListener("change", () => this.set(name, box.checked));
    this.controls.set(name, (value) => { box.checked = value; });
    return box;
  }

  words({ name, words }, id) {
    const select = make("select", { id });
    fill(select, words.map((word) => [word, word]));
    select.addEventListener("change", () => this.set(name, select.value));
    this.controls.set(name, (value) => { select.value = value; });
    return select;
  }

  touch(name) {
    this.edited.set(name, performance.now());
  }

  /** Sets a parameter. One command is sent after the other, and of values that follow each other fast only the last. */
  async set(name, value) {
    this.touch(name);
    const { group } = this;
    this.wanted.set(`${group}/${name}`, { name, value, group });
    if (this.setting) return;
    this.setting = true;
    while (this.wanted.size) {
      await new Promise((done) => setTimeout(done, SETTLE));
      const [key, newest] = this.wanted.entries().next().value;
      this.wanted.delete(key);
      await this.send(newest);
    }
    this.setting = false;
  }

  async send({ name, value, group }) {
    const whose = group ? { group } : {};
    const fine = await this.change({ policy: { [name]: value }, ...whose }, `${name} is ${value ?? "none"}${group ? ` for ${group}` : ""}`);
    if (!fine) {
      this.edited.delete(name);
      this.write();
    }
  }

  // -- words -----------------------------------------------------------------------------------------------------

  say(text, wrong = false) {
    this.told.textContent = text;
    this.told.classList.toggle("wrong", wrong);
  }

  write() {
    const { state } = this;
    if (!state.offers) return;
    this.pause.textContent = state.paused ? "Go on" : "Pause";
    this.pause.setAttribute("aria-pressed", String(state.paused));
    for (const button of [this.pause, this.step]) button.disabled = state.over;
    if (document.activeElement !== this.pace) {
      const at = PACES.reduce((best, pace, i) => (Math.abs((pace || 1e9) - (state.pace || 1e9)) < Math.abs((PACES[best] || 1e9) - (state.pace || 1e9)) ? i : best), 0);
      this.pace.value = at;
      this.paceLabel.value = label(state.pace);
    }
    this.pace.disabled = state.over;
    const can = (kind) => !state.over && state.kinds.includes(kind);
    this.drop.disabled = !can("add_box");
    this.drop.title = state.kinds.includes("add_box") || !state.kinds.length ? "" : "Not with rigid bodies, all of which are built at the beginning";
    this.kill.disabled = !can("fail");
    this.heightLabel.hidden = this.drop.disabled;
    if (state.over && this.tool) this.choose(null);
    const now = performance.now();
    for (const { name, value } of this.offer().parameters) {
      if (state.paused ? this.edited.has(name) : now - (this.edited.get(name) ?? -EDITED) < EDITED) continue;
      this.edited.delete(name);
      this.controls.get(name)(value);
    }
    for (const input of this.section.querySelectorAll(".parameter input, .parameter select")) input.disabled = !can("policy");
    const made = this.made.children.length;
    this.made.append(...state.made.slice(made).map((text) => make("li", {}, text)));
    this.record.hidden = !state.made.length;
    this.repeat.textContent = state.path ? `colonysim repeat ${state.path}` : "nothing: this run is not recorded";
  }
}
