// The edges of polygons and the faces on their two sides: borders, creases, lines between labels.
import { firstOfEqual, mix2 } from './hash.js';

const NONE = -1;
const MANY = -2;

export class EdgeTable {
  constructor({ count, offsets, corners }) {
    const n = corners.length;
    const low = new Uint32Array(n);
    const high = new Uint32Array(n);
    const faceOf = new Uint32Array(n);
    for (let f = 0; f < count; f++) {
      for (let c = offsets[f]; c < offsets[f + 1]; c++) {
        const a = corners[c];
        const b = corners[c + 1 < offsets[f + 1] ? c + 1 : offsets[f]];
        low[c] = Math.min(a, b);
        high[c] = Math.max(a, b);
        faceOf[c] = f;
      }
    }
    const first = firstOfEqual(n, (c) => mix2(low[c], high[c]), (c, d) => low[c] === low[d] && high[c] === high[d]);
    const edgeOf = new Int32Array(n);
    let edges = 0;
    for (let c = 0; c < n; c++) edgeOf[c] = first[c] === c ? edges++ : NONE;
    this.count = edges;
    this.ends = new Uint32Array(2 * edges);
    this.left = new Int32Array(edges);
    this.right = new Int32Array(edges).fill(NONE);
    for (let c = 0; c < n; c++) {
      const e = edgeOf[first[c]];
      if (first[c] === c) {
        this.ends[2 * e] = low[c];
        this.ends[2 * e + 1] = high[c];
        this.left[e] = faceOf[c];
      } else {
        this.right[e] = this.right[e] === NONE ? faceOf[c] : MANY;
      }
    }
  }

  /** Ends of the edges that `chosen(left, right)` takes; edges of more than two faces always are. */
  select(chosen) {
    const out = [];
    for (let e = 0; e < this.count; e++) {
      const right = this.right[e];
      if (right === MANY || chosen(this.left[e], right)) out.push(this.ends[2 * e], this.ends[2 * e + 1]);
    }
    return Uint32Array.from(out);
  }

  borders() {
    return this.select((_, right) => right === NONE);
  }

  /** Edges that bend by more than an angle, in degrees. */
  sharp(normals, degrees) {
    const limit = Math.cos((degrees * Math.PI) / 180);
    const n = normals;
    return this.select((f, g) => {
      if (g === NONE) return false;
      return n[3 * f] * n[3 * g] + n[3 * f + 1] * n[3 * g + 1] + n[3 * f + 2] * n[3 * g + 2] < limit;
    });
  }

  /** Edges between faces with different labels. */
  between(labels) {
    return this.select((f, g) => g !== NONE && labels[f] !== labels[g]);
  }
}
