// The data of the page: base64 -> gzip -> a head of plain data and columns as typed arrays (see view/packing.py).

// By kind and bytes. Whole numbers beyond 32 bits (times of weeks, large numbers of nodes) come as doubles.
const KINDS = { i1: Int8Array, i2: Int16Array, i4: Int32Array, f4: Float32Array, f8: Float64Array };

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

function readColumn(raw, start, kind, count, width, begin, sumKind, sumWidth) {
  const joined = new Uint8Array(count * width);
  for (let plane = 0; plane < width; plane++) {
    const from = start + begin + plane * count;
    for (let i = 0; i < count; i++) joined[i * width + plane] = raw[from + i];
  }
  const numbers = new KINDS[kind + width](joined.buffer);
  if (sumKind === undefined) return numbers;
  const sums = new KINDS[sumKind + sumWidth](count);
  let sum = 0;
  for (let i = 0; i < count; i++) sums[i] = sum += numbers[i];
  return sums;
}
