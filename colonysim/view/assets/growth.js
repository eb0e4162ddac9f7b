// A run that grows: the rows of a block are added to the columns that are there. A block is of one episode and has
// the form of a run of its own, with words and places to write to numbered in its own way.

/** What a run has before its first row. */
export function begin(run) {
  Object.assign(run, { episodes: [], fields: [], byBox: [], slotNumbers: new Map() });
}

export function extend(run, block) {
  Object.assign(run, { status: block.status, hash: block.hash, trouble: block.trouble });
  if (block.later) Object.assign(run, { later: block.later, boxes: block.boxes }); // of changes that are made by hand
  const [result] = block.episodes;
  if (!result) return;
  const begins = run.episodes.at(-1)?.[0] !== result[0];
  run.episodes.splice(run.episodes.length - (begins ? 0 : 1), 1, result);
  renumberWords(run, block);
  renumberSlots(run, block);
  for (const [table, column] of [["events", "time"], ["decisions", "time"], ["deposits", "time"], ["starts", "slot"]]) {
    const first = ((run[table] ??= {}).first ??= [0]);
    if (begins) first.push(first.at(-1));
    for (const [name, values] of Object.entries(block[table])) if (name !== "first") add(run[table], name, values);
    first[first.length - 1] = run[table][column].length;
  }
  addPoses(run, block, begins);
}

/** Adds values to the end of a column, whose memory doubles when it is full; it becomes one of doubles once it must. */
function add(table, name, values) {
  const old = table[name] ?? [];
  const wide = old instanceof Float64Array || values instanceof Float64Array;
  const Kind = wide ? Float64Array : values instanceof Float32Array ? Float32Array : Int32Array;
  const count = old.length + values.length;
  let { buffer } = old;
  if (!(old instanceof Kind) || count * Kind.BYTES_PER_ELEMENT > buffer.byteLength) {
    const room = new Kind(2 * count);
    room.set(old);
    ({ buffer } = room);
  }
  table[name] = new Kind(buffer, 0, count);
  table[name].set(values, old.length);
}

const numberOf = (words, word) => (words.includes(word) ? words.indexOf(word) : words.push(word) - 1);

function renumberWords(run, block) {
  for (const column of ["kind", "action", "status", "reason"]) {
    const known = (run[`words.${column}`] ??= []);
    const codes = block[`words.${column}`].map((word) => numberOf(known, word));
    block.events[column] = Int32Array.from(block.events[column], (code) => codes[code]);
  }
}

function renumberSlots(run, block) {
  const { slots } = block;
  const fields = block.fields.map((name) => numberOf(run.fields, name));
  run.byBox = [...new Set([...run.byBox, ...block.byBox])];
  const added = { field: [], place: [], key: [] };
  const numbers = Int32Array.from(slots.field, (code, i) => {
    const [field, place, key] = [fields[code], slots.place[i], slots.key[i]];
    const name = `${field} ${place} ${key}`;
    if (!run.slotNumbers.has(name)) {
      run.slotNumbers.set(name, run.slotNumbers.size);
      added.field.push(field);
      added.place.push(place);
      added.key.push(key);
    }
    return run.slotNumbers.get(name);
  });
  for (const [name, values] of Object.entries(added)) add((run.slots ??= {}), name, values);
  for (const table of [block.starts, block.deposits]) table.slot = Int32Array.from(table.slot, (slot) => numbers[slot]);
}

/** Poses lie body after body within an episode: those of the last episode are laid out anew. */
function addPoses(run, block, begins) {
  const bodies = run.agents.node.length + run.boxes.node.length;
  const first = run.poses?.first;
  if (begins && first) first.push(...new Array(bodies).fill(first.at(-1)));
  if (!block.poses) return;
  Object.assign(run, { bodies: run.bodies ?? block.bodies, slabs: run.slabs ?? block.slabs });
  run.poses ??= { first: new Array(bodies * run.episodes.length + 1).fill(0) };
  const from = run.poses.first.length - 1 - bodies;
  const old = run.poses.first.slice(from), fresh = block.poses.first;
  for (const [name, values] of Object.entries(block.poses)) {
    if (name === "first") continue;
    const column = run.poses[name] ?? new Int32Array(0);
    const joined = [];
    for (let body = 0; body < bodies; body++) {
      const before = column.subarray(old[body], old[body + 1]);
      const later = values.subarray(fresh[body], fresh[body + 1]);
      // Angles count on over whole turns; those of a block begin anew.
      const turn = ["roll", "pitch", "yaw"].includes(name) ? 2 * Math.PI * run.bodies.fine : 0;
      const shift = turn && before.length && later.length ? Math.round((before.at(-1) - later[0]) / turn) * turn : 0;
      joined.push(before.slice(), shift ? later.map((value) => Math.round(value + shift)) : later);
    }
    run.poses[name] = column.subarray(0, old[0]);
    for (const part of joined) add(run.poses, name, part);
  }
  for (let body = 0; body <= bodies; body++) run.poses.first[from + body] += fresh[body];
}
