// The drawn faces of a model: geometry from its triangle soup, colours from a layer, cells by slice, peel and shrink.
import * as THREE from 'three';
import { cornerNormals, faceNormals } from './normals.js';
import { MODE, faceMaterial } from './shader.js';
import { rgb } from './theme.js';

export class Skin {
  constructor(model, ramps) {
    this.model = model;
    this.ramps = ramps;
    this.layer = null;
    this.filter = null;
    this.material = faceMaterial();
    this.mesh = new THREE.Mesh(new THREE.BufferGeometry(), this.material);
    this.mesh.frustumCulled = false;
    // Drawn first where faces are transparent: only the nearest of them is seen.
    this.depth = new THREE.Mesh(this.mesh.geometry, faceMaterial());
    Object.assign(this.depth.material, { colorWrite: false, uniforms: this.material.uniforms });
    this.depth.renderOrder = -1;
    this.depth.frustumCulled = false;
    this.depth.visible = false;
    if (model.isVolume) this.visible = new Uint8Array(model.cells.count).fill(1);
    this.rebuild(false);
  }

  /** Geometry of what is visible. */
  rebuild(shrunk) {
    const { model } = this;
    this.shrunk = shrunk;
    // Shrunk cells are all there, hidden ones are left out by their `kept`.
    this.soup = model.isVolume ? model.cellFaces.skin(shrunk ? null : this.visible) : model.soup;
    const { corners, count, sides, owner } = this.soup;
    const position = new Float32Array(9 * count);
    const bary = new Uint8Array(12 * count);
    for (let c = 0; c < 3 * count; c++) {
      const v = 3 * corners[c];
      position[3 * c] = model.points[v];
      position[3 * c + 1] = model.points[v + 1];
      position[3 * c + 2] = model.points[v + 2];
      const own = c % 3;
      const side = sides[(c / 3) | 0];
      for (let i = 0; i < 3; i++) bary[4 * c + i] = i === own || !(side & (1 << i)) ? 255 : 0;
    }
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', new THREE.BufferAttribute(position, 3));
    geometry.setAttribute('bary', new THREE.BufferAttribute(bary, 4, true));
    if (model.isVolume) {
      const middle = new Float32Array(9 * count);
      for (let c = 0; c < 3 * count; c++) {
        for (let i = 0; i < 3; i++) middle[3 * c + i] = model.cellFaces.centres[3 * owner[(c / 3) | 0] + i];
      }
      geometry.setAttribute('middle', new THREE.BufferAttribute(middle, 3));
    } else {
      const normals = model.once('corner normals', () => cornerNormals(this.soup, this.normals, model.vertexCount));
      geometry.setAttribute('normal', new THREE.BufferAttribute(normals, 4, true));
    }
    this.mesh.geometry.dispose();
    this.mesh.geometry = geometry;
    this.depth.geometry = geometry;
    if (model.isVolume) this.keep(null);
    this.paint(this.layer);
    this.keepBy(this.filter);
  }

  get normals() {
    return this.model.once('face normals', () => faceNormals(this.model.points, this.model.faces));
  }

  /** One value per drawn corner. */
  spread(layer, target, width, put) {
    const { corners, owner, face } = this.soup;
    for (let c = 0; c < corners.length; c++) {
      const t = (c / 3) | 0;
      const at = layer.on === 'vertex' ? corners[c] : layer.on === 'cell' ? owner[t] : this.model.isVolume ? face[t] : owner[t];
      put(target, width * c, at);
    }
    return target;
  }

  /** Colours by a layer; `null` is plain. */
  paint(layer) {
    this.layer = layer;
    const { uniforms } = this.material;
    const { geometry } = this.mesh;
    const n = this.soup.corners.length;
    if (!layer || layer.kind === 'vector') {
      uniforms.mode.value = MODE.plain;
    } else if (layer.kind === 'scalar') {
      uniforms.mode.value = MODE.ramp;
      uniforms.ramp.value = layer.range === 'diverging' ? this.ramps.diverging : this.ramps.sequential;
      uniforms.hasInvalid.value = layer.range === 'quality';
      const values = this.spread(layer, new Float32Array(n), 1, (out, c, at) => { out[c] = at < 0 ? NaN : layer.values[at]; });
      geometry.setAttribute('value', new THREE.BufferAttribute(values, 1));
    } else {
      uniforms.mode.value = MODE.tint;
      geometry.setAttribute('tint', new THREE.BufferAttribute(this.spread(layer, new Uint8Array(4 * n), 4, tints(layer)), 4, true));
    }
  }

  /** Opaque, or as glass. */
  set opacity(value) {
    this.material.uniforms.opacity.value = value;
    this.material.transparent = value < 1;
    this.depth.visible = value < 1;
  }

  /** Draws only what has a `kept` in this range; `null`: everything. */
  keep(range) {
    this.material.uniforms.filtered.value = range !== null;
    if (range) this.material.uniforms.keep.value.set(Math.max(-3e38, range[0]), Math.min(3e38, range[1]));
  }

  set clippingPlanes(planes) {
    this.material.clippingPlanes = planes;
    this.depth.material.clippingPlanes = planes;
  }

  /** Surfaces: elements whose value of this layer is outside the range are not drawn. */
  keepBy(layer) {
    this.filter = layer;
    if (!layer || this.model.isVolume) return;
    const values = this.spread(layer, new Float32Array(this.soup.corners.length), 1, (out, c, at) => { out[c] = layer.values[at]; });
    this.mesh.geometry.setAttribute('kept', new THREE.BufferAttribute(values, 1));
  }

  /** Shows cells behind a plane and within a range of a layer; `plane` and `range` may be null. */
  showCells(plane, layer, range, shrunk) {
    const { model, visible } = this;
    const { centres } = model.cellFaces;
    let changed = shrunk !== this.shrunk;
    for (let k = 0; k < visible.length; k++) {
      let shown = 1;
      if (plane) {
        const side = plane.n[0] * centres[3 * k] + plane.n[1] * centres[3 * k + 1] + plane.n[2] * centres[3 * k + 2];
        if (side > plane.d) shown = 0;
      }
      if (range && !(layer.values[k] >= range[0] && layer.values[k] <= range[1])) shown = 0;
      if (visible[k] !== shown) {
        visible[k] = shown;
        changed = true;
      }
    }
    if (!changed) return;
    if (!shrunk || !this.shrunk) this.rebuild(shrunk);
    if (!shrunk) return;
    const { owner } = this.soup;
    const kept = new Float32Array(3 * owner.length);
    for (let t = 0; t < owner.length; t++) kept.fill(visible[owner[t]], 3 * t, 3 * t + 3);
    this.mesh.geometry.setAttribute('kept', new THREE.BufferAttribute(kept, 1));
    this.keep([0.5, 1.5]);
  }

  get visibleCount() {
    return this.visible ? this.visible.reduce((sum, v) => sum + v, 0) : this.model.faces.count;
  }

  theme(theme) {
    for (const name of ['plain', 'missing', 'invalid', 'line', 'inside']) {
      this.material.uniforms[name].value.fromArray(rgb(theme[name]));
    }
  }

  dispose() {
    this.mesh.geometry.dispose();
    this.material.dispose();
    this.depth.material.dispose();
  }
}

/** Writes the colour of labels, or the colours themselves. */
function tints(layer) {
  if (layer.kind === 'color') {
    return (out, c, at) => {
      for (let i = 0; i < 4; i++) out[c + i] = at < 0 ? 160 : layer.values[4 * at + i];
    };
  }
  const rank = new Map(Array.from(layer.labels, (label, k) => [label, k]));
  return (out, c, at) => {
    const k = at < 0 ? undefined : rank.get(layer.values[at]);
    for (let i = 0; i < 3; i++) out[c + i] = k === undefined ? 160 : layer.colors[3 * k + i];
    out[c + 3] = 255;
  };
}

/** A table of colours as a texture. */
export function rampTexture(colors) {
  const rgba = new Uint8Array((colors.length / 3) * 4).fill(255);
  for (let k = 0; k < colors.length / 3; k++) rgba.set(colors.subarray(3 * k, 3 * k + 3), 4 * k);
  const texture = new THREE.DataTexture(rgba, colors.length / 3, 1);
  texture.magFilter = THREE.LinearFilter;
  texture.minFilter = THREE.LinearFilter;
  texture.needsUpdate = true;
  return texture;
}
