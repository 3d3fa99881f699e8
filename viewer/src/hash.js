// Integers to places in an open-addressing table.

/** Links equal keys: `same(a, b)` compares, `hash(a)` spreads; returns for each the first with its key. */
export function firstOfEqual(count, hash, same) {
  let size = 16;
  while (size < 2 * count) size *= 2;
  const table = new Int32Array(size).fill(-1);
  const first = new Int32Array(count);
  for (let k = 0; k < count; k++) {
    let at = hash(k) & (size - 1);
    while (table[at] >= 0 && !same(table[at], k)) at = (at + 1) & (size - 1);
    if (table[at] < 0) table[at] = k;
    first[k] = table[at];
  }
  return first;
}

/** Mixes two integers. */
export function mix2(a, b) {
  let h = Math.imul(a ^ 0x9e3779b1, 0x85ebca6b);
  h = Math.imul(h ^ (h >>> 15) ^ b, 0xc2b2ae35);
  return (h ^ (h >>> 14)) >>> 0;
}
