// What is drawn over the faces of a model: lines, skeletons, marks, directions, the picked element.
import * as THREE from 'three';
import { LineMaterial } from 'three/addons/lines/LineMaterial.js';
import { LineSegments2 } from 'three/addons/lines/LineSegments2.js';
import { LineSegmentsGeometry } from 'three/addons/lines/LineSegmentsGeometry.js';
import { CELL_EDGES } from './cells.js';
import { rgb } from './theme.js';

/** Overlays in the order of the list, with the colour of the theme and their width in pixels. */
export const KINDS = {
  region: { title: 'Region borders', width: 2 },
  sharp: { title: 'Sharp edges', width: 1.6 },
  border: { title: 'Open borders', width: 2.4 },
  feature: { title: 'Features', width: 2 },
  track: { title: 'Motorcycle graph', width: 2 },
  field: { title: 'Frame field', width: 1 },
  vectors: { title: 'Directions', width: 1.2 },
  singular: { title: 'Irregular edges', width: 2.4 },
  marks: { title: 'Irregular vertices', width: 0 },
  skeleton: { title: 'Skeleton', width: 2.6 },
  tube: { title: 'Radii', width: 0 },
};
/** Directions drawn per model at most. */
const MOST_GLYPHS = 30000;

export class Overlays {
  constructor(model, normals) {
    this.model = model;
    this.normals = normals;
    this.group = new THREE.Group();
    this.parts = new Map();
    this.group.add(this.mark = new THREE.Group());
  }

  /** The kinds that this model has. */
  kinds() {
    const { model } = this;
    const has = (style) => model.lines.some((l) => l.style === style);
    const isSurface = !model.isVolume && model.faces.count > 0;
    const there = {
      region: isSurface && model.layers.some((l) => l.kind === 'label' && l.on === 'face'),
      sharp: isSurface, border: isSurface && this.segmentsOf('border').length > 0,
      feature: has('feature'), track: has('track'), field: has('field'), singular: has('singular'),
      vectors: this.vectorLayers().length > 0, marks: model.markers.length > 0,
      skeleton: model.nets.length > 0, tube: model.nets.length > 0,
    };
    return Object.keys(KINDS).filter((kind) => there[kind]);
  }

  /** Whether sharp edges tell something: on a rough scan they would cover everything. */
  get sharpIsClear() {
    const { edges } = this.model;
    return this.model.once('sharp is clear', () => edges.count < 500
      || edges.sharp(this.normals(), 35).length / 2 < 0.08 * edges.count);
  }

  /** What the list of layers calls a kind, by the names of the parts. */
  title(kind) {
    const parts = { marks: this.model.markers, vectors: this.vectorLayers() };
    const names = (parts[kind] ?? this.model.lines.filter((l) => l.style === kind)).map((part) => part.name);
    if (kind === 'vectors') return `Directions ${names.join(', ')}`;
    return names.length ? capital(names.join(', ')) : KINDS[kind].title;
  }

  vectorLayers() {
    // Frames are drawn as a field where there is one.
    const frames = this.model.lines.some((l) => l.style === 'field') ? ['u', 'v'] : [];
    return this.model.layers.filter((l) => l.kind === 'vector' && l.on !== 'cell' && !frames.includes(l.name));
  }

  /** Shows or hides a kind; `options` hold what it depends on. */
  set(kind, shown, options, theme) {
    const key = kind === 'sharp' ? `${kind} ${options.angle}` : kind === 'region' ? `${kind} ${options.labels?.name}` : kind;
    const old = this.parts.get(kind);
    if (old && old.key !== key) {
      this.remove(old.object);
      this.parts.delete(kind);
    }
    if (shown && !this.parts.has(kind)) {
      const object = this.make(kind, options);
      if (object) {
        this.group.add(object);
        this.parts.set(kind, { key, object });
        this.color(kind, object, theme);
      }
    }
    const part = this.parts.get(kind);
    if (part) part.object.visible = shown;
  }

  theme(theme) {
    for (const [kind, { object }] of this.parts) this.color(kind, object, theme);
    this.mark.traverse((o) => o.material?.color?.set(theme.mark));
  }

  color(kind, object, theme) {
    object.traverse((o) => {
      if (o.material?.uniforms?.fewer) {
        o.material.uniforms.fewer.value.fromArray(rgb(theme.fewer));
        o.material.uniforms.more.value.fromArray(rgb(theme.more));
        o.material.uniforms.rim.value.fromArray(rgb(theme.background));
      } else o.material?.color?.set(theme[kind]);
    });
  }

  make(kind, options) {
    if (kind === 'marks') return marks(this.model);
    if (kind === 'tube') return tubes(this.model);
    if (kind === 'skeleton') return skeleton(this.model, this);
    const segments = this.segmentsOf(kind, options);
    if (segments.length === 0) return null;
    const lines = fatLines(segments, KINDS[kind].width);
    if (kind === 'singular') lines.material.depthTest = false;
    return lines;
  }

  /** Ends of the segments of a kind, in local coordinates. */
  segmentsOf(kind, options = {}) {
    const { model } = this;
    if (kind === 'border') return model.once('border', () => this.between(model.edges.borders()));
    if (kind === 'sharp') return this.between(model.edges.sharp(this.normals(), options.angle));
    if (kind === 'region') return options.labels ? this.between(model.edges.between(options.labels.values)) : new Float32Array();
    if (kind === 'vectors') return concat(this.vectorLayers().map((layer) => glyphs(model, layer)));
    return concat(model.lines.filter((l) => l.style === kind).map((l) => l.segments ?? this.between(l.edges)));
  }

  between(edges, points = this.model.points) {
    const out = new Float32Array(3 * edges.length);
    for (let k = 0; k < edges.length; k++) {
      for (let i = 0; i < 3; i++) out[3 * k + i] = points[3 * edges[k] + i];
    }
    return out;
  }

  /** Outlines an element, or a node of a net; `null` removes the outline. */
  outline(pick, theme, shrink) {
    for (const child of [...this.mark.children]) this.remove(child);
    if (!pick) return;
    const lines = fatLines(pick.on === 'node' ? cross(pick) : outlineOf(this.model, pick, shrink), 3.5);
    lines.material.depthTest = false;
    lines.renderOrder = 5;
    lines.material.color.set(theme.mark);
    this.mark.add(lines);
  }

  clip(planes) {
    this.group.traverse((o) => {
      if (o.material && o.parent !== this.mark) o.material.clippingPlanes = planes;
    });
  }

  remove(object) {
    object.traverse((o) => {
      o.geometry?.dispose();
      o.material?.dispose();
    });
    object.removeFromParent();
  }
}

const capital = (text) => text.charAt(0).toUpperCase() + text.slice(1);

function concat(parts) {
  const out = new Float32Array(parts.reduce((sum, p) => sum + p.length, 0));
  let at = 0;
  for (const part of parts) {
    out.set(part, at);
    at += part.length;
  }
  return out;
}

function fatLines(segments, width) {
  const geometry = new LineSegmentsGeometry().setPositions(segments);
  const lines = new LineSegments2(geometry, new LineMaterial({ linewidth: width, clipping: true }));
  lines.frustumCulled = false;
  lines.renderOrder = 2;
  return lines;
}

/** Ends of the sides of an element. */
function outlineOf(model, { on, id }, shrink) {
  const corners = model.corners(on, id);
  const pairs = on === 'cell' ? CELL_EDGES[corners.length] ?? [] : Array.from(corners, (_, k) => [k, (k + 1) % corners.length]).flat();
  const { middle } = model.extent(on, id);
  const at = (k) => model.local(corners[k]).map((x, i) => middle[i] + (x - middle[i]) * (on === 'cell' ? shrink : 1));
  return Float32Array.from(pairs.flatMap(at));
}

/** A cross of the size of the node's radius. */
function cross({ point, radius }) {
  const arm = Number.isFinite(radius) && radius > 0 ? radius : 0.02;
  return Float32Array.from([0, 1, 2].flatMap((i) => [-arm, arm].flatMap((d) => point.map((x, k) => (k === i ? x + d : x)))));
}

/** Short lines along a vector layer: at some elements of a large model, at all of a small one. */
function glyphs(model, layer) {
  const onFaces = layer.on === 'face';
  const count = onFaces ? model.faces.count : model.vertexCount;
  const every = Math.max(1, Math.ceil(count / MOST_GLYPHS));
  const arm = 0.5 * Math.sqrt(8 / Math.max(1, count / every)) * 0.55;
  const out = [];
  for (let k = 0; k < count; k += every) {
    const d = [0, 1, 2].map((i) => layer.values[3 * k + i]);
    const length = Math.hypot(...d);
    if (!(length > 0)) continue;
    const p = onFaces ? model.extent('face', k).middle : model.local(k);
    out.push(...p.map((x, i) => x - (arm * d[i]) / length), ...p.map((x, i) => x + (arm * d[i]) / length));
  }
  return Float32Array.from(out);
}

/** Segments and nodes of all nets; they show through faces. */
function skeleton(model, overlays) {
  const group = new THREE.Group();
  for (const net of model.nets) {
    if (net.edges.length > 0) {
      const lines = fatLines(overlays.between(net.edges, net.points), KINDS.skeleton.width);
      // In the pass of transparent things, so that glass does not cover it.
      Object.assign(lines.material, { depthTest: false, transparent: true });
      lines.renderOrder = 3;
      group.add(lines);
    }
    const geometry = new THREE.BufferGeometry().setAttribute('position', new THREE.BufferAttribute(net.points, 3));
    const material = new THREE.PointsMaterial({ size: 5, sizeAttenuation: false, depthTest: false, transparent: true });
    const nodes = new THREE.Points(geometry, material);
    nodes.frustumCulled = false;
    nodes.renderOrder = 3;
    group.add(nodes);
  }
  return group;
}

/** Truncated cones between the balls of a net. */
function tubes(model) {
  const AROUND = 20;
  const positions = [];
  for (const net of model.nets) {
    for (let e = 0; e < net.edges.length; e += 2) {
      const ends = [net.edges[e], net.edges[e + 1]];
      const p = ends.map((v) => new THREE.Vector3().fromArray(net.points, 3 * v));
      const r = ends.map((v) => (net.radii[v] > 0 ? net.radii[v] : 0));
      const along = p[1].clone().sub(p[0]).normalize();
      const u = new THREE.Vector3(Math.abs(along.x) < 0.8 ? 1 : 0, Math.abs(along.x) < 0.8 ? 0 : 1, 0).cross(along).normalize();
      const v = along.clone().cross(u);
      const at = (end, k) => {
        const angle = (2 * Math.PI * k) / AROUND;
        return p[end].clone().addScaledVector(u, r[end] * Math.cos(angle)).addScaledVector(v, r[end] * Math.sin(angle)).toArray();
      };
      for (let k = 0; k < AROUND; k++) {
        positions.push(...at(0, k), ...at(1, k + 1), ...at(1, k), ...at(0, k), ...at(0, k + 1), ...at(1, k + 1));
      }
    }
  }
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.Float32BufferAttribute(positions, 3));
  geometry.computeVertexNormals();
  // Depth first: where cones overlap, only the nearest is seen.
  const depth = new THREE.Mesh(geometry, new THREE.MeshBasicMaterial({ colorWrite: false, side: THREE.DoubleSide }));
  const color = new THREE.Mesh(geometry, new THREE.MeshLambertMaterial({ transparent: true, opacity: 0.4, side: THREE.DoubleSide }));
  [depth, color].forEach((mesh, k) => Object.assign(mesh, { frustumCulled: false, renderOrder: 0.8 + 0.1 * k }));
  return new THREE.Group().add(depth, color);
}

const MARK_VERTEX = /* glsl */ `
  attribute float turn;
  uniform float size;
  varying float vTurn;
  #include <clipping_planes_pars_vertex>
  void main() {
    vTurn = turn;
    vec4 mvPosition = modelViewMatrix * vec4(position, 1.0);
    #include <clipping_planes_vertex>
    // A little nearer along the ray, so that the surface does not cut the marks in half.
    gl_Position = projectionMatrix * vec4(0.988 * mvPosition.xyz, 1.0);
    gl_PointSize = size;
  }`;
const MARK_FRAGMENT = /* glsl */ `
  uniform vec3 fewer;
  uniform vec3 more;
  uniform vec3 rim;
  varying float vTurn;
  #include <clipping_planes_pars_fragment>
  void main() {
    #include <clipping_planes_fragment>
    vec2 p = 2.0 * gl_PointCoord - 1.0;
    // Fewer: a triangle; more: a disc. The shapes tell what the colours tell.
    float d = vTurn < 0.0 ? max(abs(p.x) * 1.2 - p.y * 0.62, p.y) - 0.62 : length(p) - 0.82;
    if (d > 0.0) discard;
    gl_FragColor = vec4(d > -0.17 ? rim : vTurn < 0.0 ? fewer : more, 1.0);
  }`;

/** Vertices with fewer and with more quads than usual. */
function marks(model) {
  const positions = [];
  const turns = [];
  for (const m of model.markers) {
    m.vertices.forEach((v, k) => {
      positions.push(...model.local(v));
      turns.push(m.values[k] - m.usual[k]);
    });
  }
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.Float32BufferAttribute(positions, 3));
  geometry.setAttribute('turn', new THREE.Float32BufferAttribute(turns, 1));
  const color = () => ({ value: new THREE.Vector3() });
  const material = new THREE.ShaderMaterial({
    vertexShader: MARK_VERTEX, fragmentShader: MARK_FRAGMENT, clipping: true,
    uniforms: { fewer: color(), more: color(), rim: color(), size: { value: 13 * (window.devicePixelRatio || 1) } },
  });
  const points = new THREE.Points(geometry, material);
  points.frustumCulled = false;
  points.renderOrder = 4;
  return points;
}
