// A pheromone as a layer: which values belong to it, and the scale that they are all shown on.

const TITLES = { D: "distance", E: "exploration", H: "hole", B: "box" };
export const titleOf = (field) => (field in TITLES ? `${field} ${TITLES[field]}` : field);

const NOTES = {
  D: "Near the goal is bright: how near, as far as the visitors of a node know.",
  E: "Often visited is bright; evaporates between episodes.",
  H: "Bright leads to the hole. Click another hole to see its trail.",
  B: "How well the box has served for each hole. Click another box to see its own.",
};
export const noteOf = (field) => NOTES[field] ?? "";

/** What a field can be chosen by: "hole", "box" or null. */
export function keyOf(run, field) {
  if (run.byBox.includes(field)) return "box";
  const { slots } = run;
  const code = run.fields.indexOf(field);
  return slots.field.some((each, i) => each === code && slots.key[i] >= 0) ? "hole" : null;
}

/**
 * A layer: { field, by, key, nodes, slots, low, high }, where `nodes[i]` shows the value of `slots[i]`.
 * By box, the values stand on the holes; by hole, on the nodes. The scale is that of the whole run.
 */
export function layerOf(run, field, key) {
  const by = keyOf(run, field);
  const code = run.fields.indexOf(field);
  const { slots, starts, deposits } = run;
  const nodes = [], chosen = [], inside = new Uint8Array(slots.field.length);
  for (let i = 0; i < slots.field.length; i++) {
    if (slots.field[i] !== code) continue;
    if (by === "box" ? slots.place[i] !== key : by === "hole" && slots.key[i] !== key) continue;
    nodes.push(by === "box" ? slots.key[i] : slots.place[i]);
    chosen.push(i);
    inside[i] = 1;
  }
  let low = Infinity, high = -Infinity;
  for (const rows of [starts, deposits]) {
    for (let i = 0; i < rows.slot.length; i++) {
      if (!inside[rows.slot[i]]) continue;
      low = Math.min(low, rows.value[i]);
      high = Math.max(high, rows.value[i]);
    }
  }
  if (low > high) low = high = 0;
  if (low > 0 && low < 0.1 * high) low = 0; // next to nothing is nothing
  return { field, by, key, nodes: Int32Array.from(nodes), slots: Int32Array.from(chosen), low, high };
}

/** Where a value lies on a layer's scale, 0 to 1. */
export const shareOf = (layer, value) => (layer.high > layer.low ? (value - layer.low) / (layer.high - layer.low) : 1);
