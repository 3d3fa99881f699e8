// Triangles as they are drawn: three vertex ids each, which of their sides are edges of the element, and whose they are.

/** Polygons fanned from their first corner; faces with fewer than three corners are left out. */
export function surfaceSoup({ count, offsets, corners }) {
  const size = (f) => offsets[f + 1] - offsets[f];
  let total = 0;
  for (let f = 0; f < count; f++) total += Math.max(0, size(f) - 2);
  const soup = emptySoup(total);
  let t = 0;
  for (let f = 0; f < count; f++) {
    for (let k = 1; k + 1 < size(f); k++) {
      const from = offsets[f];
      const sides = sidesOf(k, size(f));
      put(soup, t++, corners[from], corners[from + k], corners[from + k + 1], sides, f, f);
    }
  }
  return soup;
}

export function emptySoup(count) {
  return {
    count,
    corners: new Uint32Array(3 * count),
    sides: new Uint8Array(count),
    owner: new Uint32Array(count),
    face: new Int32Array(count),
  };
}

export function put(soup, t, a, b, c, sides, owner, face) {
  soup.corners[3 * t] = a;
  soup.corners[3 * t + 1] = b;
  soup.corners[3 * t + 2] = c;
  soup.sides[t] = sides;
  soup.owner[t] = owner;
  soup.face[t] = face;
}

/** Bit i: the side opposite to corner i of the triangle (0, k, k + 1) is a side of the polygon. */
export const sidesOf = (k, size) => 1 | (k + 2 === size ? 2 : 0) | (k === 1 ? 4 : 0);
