// The drawing area: one canvas, one or two panes that share a camera, drawn when something changed.
import * as THREE from 'three';
import { Orbit } from './orbit.js';
import { Overlays } from './overlays.js';
import { pickFace, pickNode } from './pick.js';
import { Skin, rampTexture } from './skin.js';

export class Stage {
  constructor(canvas, ramps) {
    this.canvas = canvas;
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true });
    this.renderer.localClippingEnabled = true;
    this.renderer.autoClear = false;
    this.ramps = { sequential: rampTexture(ramps.sequential), diverging: rampTexture(ramps.diverging) };
    this.orbit = new Orbit(() => this.redraw());
    this.actors = new Map();
    this.panes = [];
    this.layout = 'single';
    this.split = 0.5;
    this.slice = null;
    this.shrink = 1;
    this.orbit.listen(canvas, (e) => this.paneAt(e), (e) => this.onpick?.(this.pick(e)));
    new ResizeObserver(() => this.resize()).observe(canvas.parentElement);
  }

  /** What draws a model; made on first use. */
  actor(model) {
    if (!this.actors.has(model)) {
      const scene = new THREE.Scene();
      const group = new THREE.Group();
      // Only the cones of radii use it; faces have a light of their own.
      scene.add(group, new THREE.HemisphereLight('#ffffff', '#777777', 3));
      const skin = new Skin(model, this.ramps);
      const overlays = new Overlays(model, () => skin.normals);
      group.add(skin.depth, skin.mesh, overlays.group);
      this.actors.set(model, { model, scene, group, skin, overlays });
    }
    return this.actors.get(model);
  }

  /** Shows these models, left to right. Models at one place share a frame; others are each brought to the same size. */
  show(models) {
    this.panes = models.map((m) => this.actor(m));
    const boxes = models.map((m) => ({ low: m.centre.map((c) => c - m.scale), high: m.centre.map((c) => c + m.scale), m }));
    const low = [0, 1, 2].map((k) => Math.min(...boxes.map((b) => b.low[k])));
    const high = [0, 1, 2].map((k) => Math.max(...boxes.map((b) => b.high[k])));
    const size = Math.max(...[0, 1, 2].map((k) => (high[k] - low[k]) / 2));
    const largest = Math.max(...models.map((m) => m.scale));
    const together = size <= 1.6 * largest && Math.min(...models.map((m) => m.scale)) > 0.2 * largest;
    for (const pane of this.panes) {
      const { centre, scale } = pane.model;
      const s = together ? scale / size : 1;
      const t = together ? [0, 1, 2].map((k) => (centre[k] - (low[k] + high[k]) / 2) / size) : [0, 0, 0];
      pane.frame = { s, t };
      pane.group.scale.setScalar(s);
      pane.group.position.set(...t);
      pane.group.updateMatrixWorld(true);
    }
    let most = 0;
    this.points((p) => { most = Math.max(most, p.lengthSq()); });
    this.orbit.reach = Math.sqrt(most) || 1;
    this.redraw();
  }

  /** Everything is seen from the present side, as large as the panes allow. */
  fit() {
    const right = new THREE.Vector3(1, 0, 0).applyQuaternion(this.orbit.turn);
    const up = new THREE.Vector3(0, 1, 0).applyQuaternion(this.orbit.turn);
    const box = { x: [Infinity, -Infinity], y: [Infinity, -Infinity] };
    this.points((p) => {
      const [x, y] = [p.dot(right), p.dot(up)];
      box.x = [Math.min(box.x[0], x), Math.max(box.x[1], x)];
      box.y = [Math.min(box.y[0], y), Math.max(box.y[1], y)];
    });
    if (!(box.x[1] >= box.x[0])) return;
    const middle = right.multiplyScalar((box.x[0] + box.x[1]) / 2).addScaledVector(up, (box.y[0] + box.y[1]) / 2);
    this.orbit.frame(middle, this.aspect(), (each) => this.points(each));
    this.fitted = this.orbit.view();
  }

  /** What was fitted stays so in panes of another shape, unless it was moved since then. */
  refit() {
    if (this.fitted && this.orbit.view() === this.fitted) this.fit();
  }

  /** Every drawn point, in the frame of the world. */
  points(each) {
    const p = new THREE.Vector3();
    for (const { model, frame } of this.panes) {
      for (const points of [model.points, ...model.nets.map((n) => n.points)]) {
        for (let k = 0; k < points.length; k += 3) {
          p.set(points[k] * frame.s + frame.t[0], points[k + 1] * frame.s + frame.t[1], points[k + 2] * frame.s + frame.t[2]);
          each(p);
        }
      }
    }
  }

  aspect() {
    const { width, height } = this.rect(0);
    return width / Math.max(1, height);
  }

  /** Where a pane is, in CSS pixels from the upper left corner. */
  rect(k) {
    const { clientWidth: w, clientHeight: h } = this.canvas.parentElement;
    if (this.panes.length < 2 || this.layout !== 'side') return { x: 0, y: 0, width: w, height: h };
    const half = Math.floor(w / 2);
    return { x: k * half, y: 0, width: k ? w - half : half, height: h };
  }

  /** The pane under the pointer, and where in it (−1 to 1, upwards). */
  paneAt(event) {
    const box = this.canvas.getBoundingClientRect();
    const [px, py] = [event.clientX - box.left, event.clientY - box.top];
    let index = 0;
    if (this.panes.length > 1 && this.layout === 'side') index = px >= this.rect(1).x ? 1 : 0;
    if (this.panes.length > 1 && this.layout === 'split') index = px >= this.split * box.width ? 1 : 0;
    const rect = this.rect(index);
    const x = (2 * (px - rect.x)) / rect.width - 1;
    const y = 1 - (2 * (py - rect.y)) / rect.height;
    return { index, x, y, aspect: rect.width / rect.height, height: rect.height, px: px - rect.x, py: py - rect.y, rect };
  }

  /** The element under the pointer. */
  pick(event) {
    const at = this.paneAt(event);
    const pane = this.panes[at.index];
    if (!pane) return null;
    const camera = this.orbit.place(at.aspect);
    const inverse = pane.group.matrixWorld.clone().invert();
    const origin = camera.position.clone().applyMatrix4(inverse);
    const through = new THREE.Vector3(at.x, at.y, 0.5).unproject(camera).applyMatrix4(inverse);
    const direction = through.sub(origin).normalize();
    const project = (p) => {
      const q = new THREE.Vector3(...p).applyMatrix4(pane.group.matrixWorld).project(camera);
      return [((q.x + 1) / 2) * at.rect.width, ((1 - q.y) / 2) * at.rect.height];
    };
    const node = pane.netsShown ? pickNode(pane.model, project, at.px, at.py) : null;
    const found = node ?? pickFace(pane.skin, origin.toArray(), direction.toArray(), this.pickOptions(pane));
    return found && { ...found, pane: at.index, model: pane.model };
  }

  pickOptions(pane) {
    return { shrink: this.shrink, plane: this.localPlane(pane), layer: pane.skin.filter, range: pane.range };
  }

  /** Where an element of a model is drawn, in CSS pixels of the canvas. */
  screenOf(model, local) {
    const index = this.panes.findIndex((p) => p.model === model);
    const rect = this.rect(index);
    const camera = this.orbit.place(rect.width / rect.height);
    const q = new THREE.Vector3(...local).applyMatrix4(this.panes[index].group.matrixWorld).project(camera);
    return [rect.x + ((q.x + 1) / 2) * rect.width, rect.y + ((1 - q.y) / 2) * rect.height];
  }

  /** Moves the camera to an element. */
  goTo(model, { middle, reach: size }) {
    const pane = this.panes.find((p) => p.model === model);
    if (!pane) return;
    const place = middle.map((x, k) => x * pane.frame.s + pane.frame.t[k]);
    this.orbit.fit(Math.max(7 * size * pane.frame.s, 1e-3 * this.orbit.reach), place, this.aspect());
  }

  /** The plane of the slice in a pane's local coordinates: what is beyond `d` along `n` is hidden. */
  localPlane(pane) {
    if (!this.slice) return null;
    const { n, d } = this.slice;
    const { s, t } = pane.frame;
    return { n, d: (d - n[0] * t[0] - n[1] * t[1] - n[2] * t[2]) / s };
  }

  /** Applies slice, shrink and the range of values to a pane. */
  cut(pane, layer, range) {
    const { skin, overlays, model } = pane;
    const fits = layer && (model.isVolume ? layer.on === 'cell' : layer.on !== 'cell');
    if (!fits) [layer, range] = [null, null];
    pane.range = range;
    const planes = this.slice ? [new THREE.Plane(new THREE.Vector3(...this.slice.n).negate(), this.slice.d)] : null;
    if (model.isVolume) {
      skin.showCells(this.localPlane(pane), layer, range, this.shrink < 1);
      skin.material.uniforms.shrink.value = this.shrink;
    } else {
      skin.clippingPlanes = planes;
      overlays.clip(planes);
      if (skin.filter !== layer) skin.keepBy(layer);
      skin.keep(range);
    }
    this.redraw();
  }

  resize() {
    const { clientWidth: w, clientHeight: h } = this.canvas.parentElement;
    if (w === 0 || h === 0) return;
    this.renderer.setPixelRatio(Math.min(2, window.devicePixelRatio || 1));
    this.renderer.setSize(w, h);
    this.refit();
    this.draw();
  }

  redraw() {
    this.pending ??= requestAnimationFrame(() => this.draw());
  }

  draw() {
    if (this.pending) cancelAnimationFrame(this.pending);
    this.pending = null;
    const { renderer } = this;
    const { clientWidth: w, clientHeight: h } = this.canvas.parentElement;
    renderer.setScissorTest(false);
    renderer.setClearColor(this.background ?? '#fff');
    renderer.clear();
    renderer.setScissorTest(true);
    this.panes.forEach((pane, k) => {
      if (k > 0 && this.layout === 'single') return;
      const rect = this.rect(k);
      const cut = this.layout === 'split' && this.panes.length > 1 ? Math.round(this.split * w) : null;
      const [from, to] = cut === null ? [rect.x, rect.x + rect.width] : k === 0 ? [0, cut] : [cut, w];
      renderer.setViewport(rect.x, 0, rect.width, h);
      renderer.setScissor(from, 0, Math.max(0, to - from), h);
      renderer.render(pane.scene, this.orbit.place(rect.width / Math.max(1, rect.height)));
    });
    this.ondraw?.();
  }
}
