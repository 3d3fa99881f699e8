// Volume cells: their faces, which faces two cells share, and the skin of those that are visible.
import { firstOfEqual, mix2 } from './hash.js';
import { emptySoup, put, sidesOf } from './soup.js';

/** Faces by the number of corners of a cell, counter-clockwise from outside (VTK corner order). */
const FACES = {
  4: [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
  5: [[0, 3, 2, 1], [0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]],
  6: [[0, 2, 1], [3, 4, 5], [0, 1, 4, 3], [1, 2, 5, 4], [2, 0, 3, 5]],
  8: [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]],
};
/** Ends of the edges of a cell, by its number of corners. */
export const CELL_EDGES = {
  4: [0, 1, 1, 2, 2, 0, 0, 3, 1, 3, 2, 3],
  5: [0, 1, 1, 2, 2, 3, 3, 0, 0, 4, 1, 4, 2, 4, 3, 4],
  6: [0, 1, 1, 2, 2, 0, 3, 4, 4, 5, 5, 3, 0, 3, 1, 4, 2, 5],
  8: [0, 1, 1, 2, 2, 3, 3, 0, 4, 5, 5, 6, 6, 7, 7, 4, 0, 4, 1, 5, 2, 6, 3, 7],
};
const ABSENT = 0xffffffff;

export class CellFaces {
  constructor({ cells, faces, points }) {
    const sizeOf = (k) => cells.offsets[k + 1] - cells.offsets[k];
    let count = 0;
    for (let k = 0; k < cells.count; k++) count += FACES[sizeOf(k)]?.length ?? 0;
    this.count = count;
    this.cell = new Uint32Array(count);
    this.corners = new Uint32Array(4 * count).fill(ABSENT);
    let f = 0;
    for (let k = 0; k < cells.count; k++) {
      for (const face of FACES[sizeOf(k)] ?? []) {
        this.cell[f] = k;
        for (let i = 0; i < face.length; i++) this.corners[4 * f + i] = cells.corners[cells.offsets[k] + face[i]];
        f += 1;
      }
    }
    this.match(faces);
    this.centres = centres(cells, points);
  }

  /** The face on the other side of each, and the face of the file at the same place. */
  match(faces) {
    const listed = [];
    for (let k = 0; k < faces.count; k++) {
      const size = faces.offsets[k + 1] - faces.offsets[k];
      if (size === 3 || size === 4) listed.push(k);
    }
    const total = this.count + listed.length;
    const keys = new Uint32Array(4 * total);
    keys.set(this.corners);
    listed.forEach((k, i) => {
      const at = 4 * (this.count + i);
      keys[at + 3] = ABSENT;
      keys.set(faces.corners.subarray(faces.offsets[k], faces.offsets[k + 1]), at);
    });
    for (let f = 0; f < total; f++) sort4(keys, 4 * f);
    const same = (f, g) => keys[4 * f] === keys[4 * g] && keys[4 * f + 1] === keys[4 * g + 1]
      && keys[4 * f + 2] === keys[4 * g + 2] && keys[4 * f + 3] === keys[4 * g + 3];
    const hash = (f) => mix2(mix2(keys[4 * f], keys[4 * f + 1]), mix2(keys[4 * f + 2], keys[4 * f + 3]));
    const first = firstOfEqual(total, hash, same);
    this.twin = new Int32Array(this.count).fill(-1);
    this.face = new Int32Array(this.count).fill(-1);
    for (let f = 0; f < this.count; f++) {
      if (first[f] === f) continue;
      this.twin[f] = first[f];
      this.twin[first[f]] = f;
    }
    listed.forEach((k, i) => {
      const f = first[this.count + i];
      if (f >= this.count) return;
      this.face[f] = k;
      if (this.twin[f] >= 0) this.face[this.twin[f]] = k;
    });
  }

  /** Triangles of the faces of visible cells that no visible cell hides; of all faces where `visible` is null. */
  skin(visible) {
    const shown = [];
    let triangles = 0;
    for (let f = 0; f < this.count; f++) {
      const twin = this.twin[f];
      if (visible && (!visible[this.cell[f]] || (twin >= 0 && visible[this.cell[twin]]))) continue;
      shown.push(f);
      triangles += this.corners[4 * f + 3] === ABSENT ? 1 : 2;
    }
    const soup = emptySoup(triangles);
    let t = 0;
    for (const f of shown) {
      const c = this.corners;
      const size = c[4 * f + 3] === ABSENT ? 3 : 4;
      for (let k = 1; k + 1 < size; k++) {
        put(soup, t++, c[4 * f], c[4 * f + k], c[4 * f + k + 1], sidesOf(k, size), this.cell[f], this.face[f]);
      }
    }
    return soup;
  }
}

/** Sorts four neighbours in place: a network of five exchanges. */
function sort4(a, at) {
  for (const [i, j] of NETWORK) {
    const [x, y] = [a[at + i], a[at + j]];
    if (x > y) {
      a[at + i] = y;
      a[at + j] = x;
    }
  }
}
const NETWORK = [[0, 1], [2, 3], [0, 2], [1, 3], [1, 2]];

function centres(cells, points) {
  const out = new Float32Array(3 * cells.count);
  for (let k = 0; k < cells.count; k++) {
    const size = cells.offsets[k + 1] - cells.offsets[k];
    for (let c = cells.offsets[k]; c < cells.offsets[k + 1]; c++) {
      for (let i = 0; i < 3; i++) out[3 * k + i] += points[3 * cells.corners[c] + i] / size;
    }
  }
  return out;
}
