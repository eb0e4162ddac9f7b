// The data of the page: base64 -> gzip -> a head of plain data and columns as typed arrays (see view/packing.py).

const WHOLE = { 1: Int8Array, 2: Int16Array, 4: Int32Array };

/** The run: its head, with the columns of each table as `run[table][column]`. */
export async function unpack(text) {
  const letters = atob(text);
  const packed = new Uint8Array(letters.length);
  for (let i = 0; i < letters.length; i++) packed[i] = letters.charCodeAt(i);
  return decode(packed);
}

/** The same of a block as it is. */
export async function decode(packed) {
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  const raw = new Uint8Array(await new Response(stream).arrayBuffer());
  const length = new DataView(raw.buffer).getUint32(0, true);
  const run = JSON.parse(new TextDecoder().decode(raw.subarray(4, 4 + length)));
  for (const [name, described] of Object.entries(run.columns)) {
    const [table, column] = name.split(".");
    const numbers = readColumn(raw, 4 + length, ...described);
    if (column === undefined) run[table] = numbers;
    else (run[table] ??= {})[column] = numbers;
  }
  return run;
}

function readColumn(raw, start, kind, count, width, steps, begin) {
  const joined = new Uint8Array(count * width);
  for (let plane = 0; plane < width; plane++) {
    const from = start + begin + plane * count;
    for (let i = 0; i < count; i++) joined[i * width + plane] = raw[from + i];
  }
  const numbers = kind === "f" ? new Float32Array(joined.buffer) : new WHOLE[width](joined.buffer);
  if (!steps) return numbers;
  const sums = new Int32Array(count);
  let sum = 0;
  for (let i = 0; i < count; i++) sums[i] = sum += numbers[i];
  return sums;
}
