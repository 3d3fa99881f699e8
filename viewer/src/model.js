// A scene of the page: decoded arrays, and what is asked of them. Ids are those of the file, from 0.
import { CellFaces } from './cells.js';
import { EdgeTable } from './edges.js';
import { surfaceSoup } from './soup.js';

export class Model {
  constructor(packed, read, index) {
    Object.assign(this, { index, name: packed.name, role: packed.role, centre: packed.centre, scale: packed.scale });
    Object.assign(this, { eye: packed.eye, up: packed.up, show: packed.show, vertexCount: packed.vertices });
    this.points = read(packed.points);
    this.faces = polygons(packed.faces, read);
    this.cells = polygons(packed.cells, read);
    this.layers = packed.layers.map((layer) => decodeLayer(layer, read));
    this.lines = packed.lines.map((l) => ({ ...l, edges: l.edges && read(l.edges), segments: l.segments && read(l.segments) }));
    this.nets = packed.nets.map((n) => ({ ...n, points: read(n.points), radii: read(n.radii), edges: read(n.edges) }));
    this.markers = packed.markers.map((m) => ({
      ...m, vertices: read(m.vertices), values: read(m.values), usual: read(m.usual),
    }));
    this.isVolume = this.cells.count > 0;
    this.memo = new Map();
  }

  /** Computed on first use. */
  once(key, make) {
    if (!this.memo.has(key)) this.memo.set(key, make());
    return this.memo.get(key);
  }

  get soup() {
    return this.once('soup', () => surfaceSoup(this.faces));
  }

  get edges() {
    return this.once('edges', () => new EdgeTable(this.faces));
  }

  get cellFaces() {
    return this.once('cells', () => new CellFaces(this));
  }

  /** What elements are called: faces by their corners, cells by theirs. */
  kindOf(on, id) {
    const list = on === 'cell' ? this.cells : this.faces;
    const size = list.offsets[id + 1] - list.offsets[id];
    if (on === 'cell') return { 4: 'tetrahedron', 5: 'pyramid', 6: 'wedge', 8: 'hexahedron' }[size] ?? 'cell';
    return { 3: 'triangle', 4: 'quad' }[size] ?? `polygon of ${size}`;
  }

  corners(on, id) {
    const list = on === 'cell' ? this.cells : this.faces;
    return list.corners.subarray(list.offsets[id], list.offsets[id + 1]);
  }

  local(v) {
    return [this.points[3 * v], this.points[3 * v + 1], this.points[3 * v + 2]];
  }

  /** Coordinates of the file. */
  toFile(p) {
    return p.map((x, k) => x * this.scale + this.centre[k]);
  }

  /** A point of the file as text: digits beyond single precision are left out. */
  pointText(p) {
    const decimals = Math.max(0, Math.min(100, 7 - Math.ceil(Math.log10(this.scale))));
    const text = (x) => (Math.abs(x) >= 1e21 || decimals > 20 ? String(Number(x.toPrecision(7))) : String(Number(x.toFixed(decimals))));
    return this.toFile(p).map(text).join(', ');
  }

  /** Mean of the corners, and the largest distance of a corner from it; in local coordinates. */
  extent(on, id) {
    const points = Array.from(this.corners(on, id), (v) => this.local(v));
    const middle = [0, 1, 2].map((k) => points.reduce((sum, p) => sum + p[k], 0) / points.length);
    const reach = Math.max(...points.map((p) => Math.hypot(p[0] - middle[0], p[1] - middle[1], p[2] - middle[2])));
    return { middle, reach };
  }

  layerNamed(name) {
    return this.layers.find((l) => l.name === name);
  }

  get quality() {
    return this.layers.find((l) => l.range === 'quality');
  }
}

/** Offsets and corners of polygons or cells. */
function polygons(packed, read) {
  const offsets = new Uint32Array(packed.count + 1);
  const sizes = packed.sizes && read(packed.sizes);
  for (let k = 0; k < packed.count; k++) offsets[k + 1] = offsets[k] + (sizes ? sizes[k] : packed.size);
  return { count: packed.count, offsets, corners: read(packed.corners) };
}

function decodeLayer(layer, read) {
  const out = { ...layer, values: read(layer.values) };
  if (layer.kind === 'label') Object.assign(out, { labels: read(layer.labels), colors: read(layer.colors) });
  if (layer.kind === 'scalar') out.stats = statistics(out.values, layer.range);
  return out;
}

/** Extremes, mean and the range that colours span: quality 0 to 1, else without the outer 2 % on each side. */
function statistics(values, range) {
  const finite = values.filter(Number.isFinite).sort();
  const n = finite.length;
  if (n === 0) return { count: 0, min: 0, max: 0, mean: 0, low: 0, high: 1, p02: 0 };
  const at = (share) => finite[Math.min(n - 1, Math.max(0, Math.ceil(share * n) - 1))];
  const mean = finite.reduce((sum, x) => sum + x, 0) / n;
  const p02 = at(0.02);
  let [low, high] = [p02, at(0.98)];
  if (range === 'quality') [low, high] = [0, 1];
  if (range === 'diverging') {
    const bound = Math.max(Math.abs(low), Math.abs(high));
    [low, high] = [-bound, bound];
  }
  if (!(high > low)) [low, high] = finite[0] < finite[n - 1] ? [finite[0], finite[n - 1]] : [low - 0.5, low + 0.5];
  return { count: n, min: finite[0], max: finite[n - 1], mean, low, high, p02 };
}

/** The value of a layer at an element, as a person reads it. */
export function valueText(layer, id) {
  const v = layer.values;
  if (layer.kind === 'scalar') return number(v[id] * layer.unit);
  if (layer.kind === 'label') return layer.words[v[id]] ? `${v[id]} (${layer.words[v[id]]})` : String(v[id]);
  if (layer.kind === 'vector') return [0, 1, 2].map((k) => number(v[3 * id + k], 5)).join(', ');
  return `rgba ${Array.from(v.subarray(4 * id, 4 * id + 4)).join(' ')}`;
}

/** Numbers are held in single precision: seven digits. */
export function number(x, digits = 7) {
  if (!Number.isFinite(x)) return Number.isNaN(x) ? 'none' : String(x);
  if (Number.isInteger(x) && Math.abs(x) < 1e9) return String(x);
  return String(Number(x.toPrecision(digits)));
}

export const grouped = (n) => n.toLocaleString('en-US').replaceAll(',', '\u202f');
