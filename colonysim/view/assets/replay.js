// One episode at one moment: what the rows up to there add up to. Times are milliseconds.

export const ACTIVE = 0, AT_GOAL = 1, SPENT = 2, LOST = 3, ABSENT = 4;

/** The first place in `times[from..to)` whose value is greater than `time`. */
export function after(times, time, from, to) {
  while (from < to) {
    const middle = (from + to) >> 1;
    if (times[middle] <= time) from = middle + 1;
    else to = middle;
  }
  return from;
}

export class Replay {
  constructor(run) {
    this.run = run;
    const { nodes, edges, agents, boxes, slots } = run;
    this.floor = new Float32Array(nodes.x.length);
    this.taken = new Uint8Array(edges.a.length); // 1 for edges that are not there now
    this.goal = run.goal;
    this.surface = new Float32Array(nodes.x.length);
    this.rims = new Map(run.holes.map(([node, , rim]) => [node, rim]));
    this.stacks = new Map(); // node -> boxes from bottom to top
    this.boxNode = new Int32Array(boxes.node.length);
    this.agentNode = new Int32Array(agents.node.length);
    this.state = new Uint8Array(agents.node.length);
    this.waitsFor = new Int32Array(agents.node.length);
    this.stopped = new Uint8Array(agents.node.length); // 1 for who stands still for a while
    this.values = new Float32Array(slots.field.length); // NaN where nobody has left anything
    this.agentX = new Float32Array(agents.node.length);
    this.agentY = new Float32Array(agents.node.length);
    this.action = new Int32Array(agents.node.length); // the event that will end what each agent does now, or -1
    this.boxX = new Float32Array(boxes.node.length);
    this.boxY = new Float32Array(boxes.node.length);
    this.pushed = new Uint8Array(boxes.node.length);
    this.code = (column, word) => run[`words.${column}`].indexOf(word);
    this.END = this.code("kind", "end");
    this.PUSH = this.code("action", "push");
    this.ARRIVED = this.code("status", "arrived");
    this.STOPPED = this.code("reason", "stopped");
    this.kinds = { goal: AT_GOAL, spent: SPENT, lost: LOST };
    this.pose = new Float64Array(6);
    this.surfaceVersion = this.markVersion = 0;
    this.open(0);
  }

  /** Goes to the start of an episode, by its place in the run. */
  open(episode) {
    const { events, deposits } = this.run;
    this.episode = episode;
    this.first = events.first[episode];
    this.last = events.first[episode + 1];
    this.firstDeposit = deposits.first[episode];
    this.lastDeposit = deposits.first[episode + 1];
    this.duration = Math.max(1, this.last > this.first ? events.time[this.last - 1] : 1);
    this.indexEnds();
    this.rewind();
    this.seek(0);
  }

  /** Takes note of rows that were added to the run: of the shown episode they lie ahead. */
  grown() {
    const { events, deposits, slots } = this.run;
    const passed = this.nextEnd.map((next, agent) => next - this.endsFirst[agent]);
    this.last = events.first[this.episode + 1];
    this.lastDeposit = deposits.first[this.episode + 1];
    this.duration = Math.max(1, this.last > this.first ? events.time[this.last - 1] : 1);
    this.makeRoom();
    this.indexEnds();
    this.nextEnd.set(passed.map((count, agent) => this.endsFirst[agent] + count));
    if (slots.field.length > this.values.length) {
      const { values } = this;
      this.values = new Float32Array(2 * slots.field.length).fill(NaN);
      this.values.set(values);
    }
    this.choicesFirst = null;
    this.markVersion++;
    this.place();
  }

  /** A box that was dropped by hand needs a place of its own. */
  makeRoom() {
    const count = this.run.boxes.node.length;
    if (count === this.boxNode.length) return;
    for (const [name, Kind, none] of [["boxNode", Int32Array, -1], ["boxX", Float32Array, NaN], ["boxY", Float32Array, NaN], ["pushed", Uint8Array, 0]]) {
      const more = new Kind(count).fill(none);
      more.set(this[name]);
      this[name] = more;
    }
  }

  /** For each agent the events that end its actions, one agent after the other; and how long the longest took. */
  indexEnds() {
    const { events } = this.run;
    const count = this.agentNode.length;
    this.endsFirst = new Int32Array(count + 1);
    for (let i = this.first; i < this.last; i++) if (events.kind[i] === this.END) this.endsFirst[events.agent[i] + 1]++;
    for (let agent = 0; agent < count; agent++) this.endsFirst[agent + 1] += this.endsFirst[agent];
    this.ends = new Int32Array(this.endsFirst[count]);
    const next = this.endsFirst.slice(0, count);
    this.longest = 0;
    for (let i = this.first; i < this.last; i++) {
      if (events.kind[i] !== this.END) continue;
      this.ends[next[events.agent[i]]++] = i;
      this.longest = Math.max(this.longest, events.took[i]);
    }
    this.nextEnd = next;
  }

  rewind() {
    const { run } = this;
    const { nodes, agents, boxes, starts } = run;
    this.cursor = this.first;
    this.marks = this.firstDeposit;
    this.time = 0;
    this.floor.set(nodes.z);
    this.surface.set(nodes.z);
    this.taken.fill(0);
    for (const edge of run.later.edges) this.taken[edge] = 1;
    this.goal = run.goal;
    this.stacks.clear();
    this.boxNode.fill(-1);
    boxes.node.forEach((node, box) => { if (box < boxes.node.length - run.later.boxes) this.put(box, node); });
    this.agentNode.set(agents.node);
    this.state.fill(ACTIVE).fill(ABSENT, agents.node.length - run.later.agents);
    this.waitsFor.fill(-1);
    this.stopped.fill(0);
    this.nextEnd.set(this.endsFirst.subarray(0, this.nextEnd.length));
    this.values.fill(NaN);
    const to = starts.first[this.episode + 1];
    for (let i = starts.first[this.episode]; i < to; i++) this.values[starts.slot[i]] = starts.value[i];
    this.surfaceVersion++;
    this.markVersion++;
  }

  /** Goes to a moment: all that has happened by then. */
  seek(time) {
    const { events } = this.run;
    const target = after(events.time, time, this.first, this.last);
    this.goTo(target, Math.min(Math.max(time, 0), this.duration));
  }

  /** Goes to just after an event, by its row; those of the same moment that follow have not yet happened. */
  seekEvent(row) {
    const clamped = Math.min(Math.max(row, this.first), this.last - 1);
    this.goTo(clamped + 1, this.run.events.time[clamped] ?? 0);
  }

  goTo(cursor, time) {
    if (cursor < this.cursor || time < this.time) this.rewind();
    while (this.cursor < cursor) this.apply(this.cursor++);
    this.deposit(time);
    this.time = time;
    this.place();
  }

  /** Writes all marks that have been left by a moment. */
  deposit(time) {
    const { deposits } = this.run;
    while (this.marks < this.lastDeposit && deposits.time[this.marks] <= time) {
      this.values[deposits.slot[this.marks]] = deposits.value[this.marks++];
      this.markVersion++;
    }
  }

  apply(row) {
    const { events } = this.run;
    const agent = events.agent[row];
    if (events.kind[row] === this.END) {
      this.nextEnd[agent]++;
      this.agentNode[agent] = events.now_at[row];
      this.waitsFor[agent] = -1;
      this.stopped[agent] = 0;
      if (events.boxTo[row] >= 0 && events.boxTo[row] !== this.boxNode[events.box[row]]) this.move(events.box[row], events.boxTo[row]);
      return;
    }
    const kind = this.run["words.kind"][events.kind[row]];
    if (kind === "change") this.change(row);
    else if (kind === "start") this.state[agent] = ACTIVE;
    else if (kind === "wait") {
      this.stopped[agent] = events.reason[row] === this.STOPPED ? 1 : 0;
      this.waitsFor[agent] = events.target[row] >= 0 ? events.target[row] : events.node[row];
    }
    else if (kind in this.kinds) this.state[agent] = this.kinds[kind];
  }

  /** What the scenario's timeline does. */
  change(row) {
    const { events } = this.run;
    const node = events.node[row], box = events.box[row];
    const action = this.run["words.action"][events.action[row]];
    if (action === "add_edge" || action === "remove_edge") this.taken[this.edge(node, events.target[row])] = action === "remove_edge" ? 1 : 0;
    else if (action === "add_box") this.put(box, node);
    else if (action === "remove_box") this.take(box);
    else if (action === "move_goal") this.goal = node;
    else if (action === "set_surface") {
      this.floor[node] = this.run.later.surfaces[events.step[row]];
      this.level(node);
    } else if (action === "wipe") this.wipe(this.run.later.wipes[events.step[row]], events.time[row]);
    this.surfaceVersion++;
    this.markVersion++;
  }

  /** Takes marks away: of some fields or of all, on some nodes; of a field of boxes, of those that stand there. */
  wipe({ fields, nodes }, time) {
    this.deposit(time); // what was left before goes too
    const { slots, fields: names, byBox } = this.run;
    const wiped = new Set(nodes);
    for (let i = 0; i < slots.field.length; i++) {
      const name = names[slots.field[i]];
      if (fields && !fields.includes(name)) continue;
      if (wiped.has(byBox.includes(name) ? this.boxNode[slots.place[i]] : slots.place[i])) this.values[i] = NaN;
    }
  }

  /** The place of an edge in the run's list. */
  edge(i, j) {
    const { a, b } = this.run.edges;
    return a.findIndex((node, e) => (node === i && b[e] === j) || (node === j && b[e] === i));
  }

  /** Whether an agent is to be seen: it has joined and not left. */
  present(agent) {
    return this.state[agent] !== AT_GOAL && this.state[agent] !== ABSENT;
  }

  put(box, node) {
    if (!this.stacks.has(node)) this.stacks.set(node, []);
    this.stacks.get(node).push(box);
    this.boxNode[box] = node;
    this.level(node);
  }

  move(box, node) {
    this.take(box);
    this.put(box, node);
    this.surfaceVersion++;
  }

  take(box) {
    const old = this.boxNode[box];
    const rest = this.stacks.get(old).filter((other) => other !== box);
    if (rest.length) this.stacks.set(old, rest);
    else this.stacks.delete(old);
    this.level(old);
    this.boxNode[box] = -1;
  }

  level(node) {
    const { boxes } = this.run;
    this.surface[node] = (this.stacks.get(node) ?? []).reduce((height, box) => height + boxes.height[box], this.floor[node]);
  }

  /** How many boxes a box stands on, of those that do not lie in the node's hole. */
  above(box) {
    const stack = this.stacks.get(this.boxNode[box]);
    return stack.filter((other) => !this.seated(other)).indexOf(box);
  }

  /** Whether a box lies in a hole: its underside is below the rim. */
  seated(box) {
    const node = this.boxNode[box];
    const rim = this.rims.get(node);
    if (rim === undefined || this.pushed[box]) return false;
    const { boxes } = this.run;
    let base = this.floor[node];
    for (const other of this.stacks.get(node)) {
      if (other === box) break;
      base += boxes.height[other];
    }
    return base < rim - this.run.reach;
  }

  /** Where everything is at this very moment, between its nodes too. */
  place() {
    const { run, time } = this;
    const { nodes, events } = run;
    this.pushed.fill(0);
    for (let box = 0; box < this.boxNode.length; box++) { // NaN for one that is not there: nothing is drawn at it
      this.boxX[box] = nodes.x[this.boxNode[box]] ?? NaN;
      this.boxY[box] = nodes.y[this.boxNode[box]] ?? NaN;
    }
    for (let agent = 0; agent < this.agentNode.length; agent++) {
      const here = this.agentNode[agent];
      this.agentX[agent] = nodes.x[here];
      this.agentY[agent] = nodes.y[here];
      this.action[agent] = -1;
      const next = this.nextEnd[agent];
      if (next >= this.endsFirst[agent + 1] || this.state[agent] !== ACTIVE) continue;
      const row = this.ends[next];
      const began = events.time[row] - events.took[row];
      if (began > time || events.target[row] < 0) continue;
      this.action[agent] = row;
      let share = events.took[row] ? Math.min((time - began) / events.took[row], 1) : 1;
      const there = events.target[row];
      const stays = events.now_at[row] !== there;
      if (events.action[row] === this.PUSH && events.box[row] >= 0) {
        const box = events.box[row];
        const lands = events.boxTo[row] === there;
        const far = lands ? share : 0.4 * Math.sin(Math.PI * share);
        this.boxX[box] += far * (nodes.x[there] - nodes.x[this.boxNode[box]]);
        this.boxY[box] += far * (nodes.y[there] - nodes.y[this.boxNode[box]]);
        this.pushed[box] = 1;
      }
      // Who does not get there goes some way and comes back.
      if (stays) share = 0.4 * Math.sin(Math.PI * share);
      this.agentX[agent] += share * (nodes.x[there] - nodes.x[here]);
      this.agentY[agent] += share * (nodes.y[there] - nodes.y[here]);
    }
    if (run.bodies) this.placeBodies();
  }

  placeBodies() {
    const { scale } = this.run.bodies;
    const agents = this.agentNode.length;
    for (let body = 0; body < agents + this.boxNode.length; body++) {
      if ((body >= agents && this.boxNode[body - agents] < 0) || !this.poseOf(body)) continue;
      const [xs, ys, i] = body < agents ? [this.agentX, this.agentY, body] : [this.boxX, this.boxY, body - agents];
      xs[i] = this.pose[0] / scale;
      ys[i] = this.pose[1] / scale;
    }
  }

  /** Puts the pose of a body (agents first, then boxes) into `pose`: metres and radians; false if there is none. */
  poseOf(body) {
    const { poses, bodies } = this.run;
    const base = this.episode * (this.agentNode.length + this.boxNode.length) + body;
    const from = poses.first[base], to = poses.first[base + 1];
    if (from === to) return false;
    const next = after(poses.time, this.time, from, to);
    const before = Math.max(next - 1, from);
    let share = 0;
    if (next < to && next > from) {
      // Bodies that do not move leave no rows: they stay where they are until shortly before the next one.
      const gap = Math.min(poses.time[next] - poses.time[before], 110);
      share = Math.max(0, 1 - (poses.time[next] - this.time) / gap);
    }
    ["x", "y", "z", "roll", "pitch", "yaw"].forEach((name, i) => {
      const value = poses[name][before];
      this.pose[i] = (value + share * (poses[name][Math.min(next, to - 1)] - value)) / bodies.fine;
    });
    return true;
  }

  /** The last decision of an agent so far, or null. */
  decisionOf(agent) {
    const { decisions } = this.run;
    const from = decisions.first[this.episode];
    for (let row = after(decisions.time, this.time, from, decisions.first[this.episode + 1]) - 1; row >= from; row--) {
      if (decisions.agent[row] === agent) return this.readDecision(row);
    }
    return null;
  }

  readDecision(row) {
    const { decisions, chance } = this.run;
    if (!this.choicesFirst) {
      this.choicesFirst = new Int32Array(decisions.count.length + 1);
      decisions.count.forEach((count, i) => { this.choicesFirst[i + 1] = this.choicesFirst[i] + count; });
    }
    const choices = [];
    for (let i = this.choicesFirst[row]; i < this.choicesFirst[row + 1]; i++) {
      choices.push({ target: decisions.targets[i], box: decisions.boxes[i], chance: decisions.chances[i] / chance });
    }
    const [time, node, chosen] = [decisions.time[row], decisions.node[row], decisions.chosen[row]];
    return { time, node, chosen, explored: decisions.explored[row] === 1, choices };
  }
}
