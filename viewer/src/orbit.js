// The camera: turns around a target, pans, zooms to the pointer; mouse, touch, keys.
import * as THREE from 'three';

const FIELD_OF_VIEW = 25;
/** Room around what is fitted: below and above it are bars. */
const MARGIN = 1.13;

export class Orbit {
  constructor(changed) {
    this.changed = changed;
    this.camera = new THREE.PerspectiveCamera(FIELD_OF_VIEW, 1, 0.01, 100);
    this.target = new THREE.Vector3();
    this.turn = new THREE.Quaternion();
    this.distance = 5;
    this.home = { eye: [0, -1, 0.4], up: [0, 0, 1] };
    this.reach = 1;
  }

  /** Looks from a side: towards the eye, and upwards. */
  lookFrom(eye, up) {
    const m = new THREE.Matrix4().lookAt(new THREE.Vector3(...eye), new THREE.Vector3(), new THREE.Vector3(...up));
    this.upward = new THREE.Vector3(...up).normalize();
    this.turn.setFromRotationMatrix(m);
    this.changed();
  }

  /** All of a ball is seen. */
  fit(radius = this.reach, middle = [0, 0, 0], aspect = 1) {
    this.target.fromArray(middle);
    const half = (FIELD_OF_VIEW / 2) * (Math.PI / 180);
    this.distance = radius / Math.sin(Math.atan(Math.tan(half) * Math.min(1, aspect)));
    this.changed();
  }

  /** Looks at a place from as near as all points allow. */
  frame(middle, aspect, points) {
    this.target.copy(middle);
    const back = this.turn.clone().invert();
    const half = Math.tan((FIELD_OF_VIEW / 2) * (Math.PI / 180)) / MARGIN;
    const q = new THREE.Vector3();
    let distance = 0;
    points((p) => {
      q.copy(p).sub(middle).applyQuaternion(back);
      distance = Math.max(distance, q.z + Math.max(Math.abs(q.x) / aspect, Math.abs(q.y)) / half);
    });
    this.distance = Math.max(distance, 1e-3 * this.reach);
    this.changed();
  }

  /** What is seen, to be compared. */
  view() {
    return [this.distance, ...this.target.toArray(), ...this.turn.toArray()].join(' ');
  }

  rotate(dx, dy) {
    const right = new THREE.Vector3(1, 0, 0).applyQuaternion(this.turn);
    // Upside down, a drag to the right still turns what is near to the right.
    const sign = new THREE.Vector3(0, 1, 0).applyQuaternion(this.turn).dot(this.upward) < 0 ? -1 : 1;
    const q = new THREE.Quaternion().setFromAxisAngle(this.upward, -sign * dx);
    this.turn.premultiply(new THREE.Quaternion().setFromAxisAngle(right, -dy)).premultiply(q).normalize();
    this.changed();
  }

  /** By shares of the height of the pane. */
  pan(dx, dy) {
    const size = 2 * this.distance * Math.tan((FIELD_OF_VIEW / 2) * (Math.PI / 180));
    this.target.add(new THREE.Vector3(-dx * size, dy * size, 0).applyQuaternion(this.turn));
    this.changed();
  }

  /** Towards a place of the pane (−1 to 1, upwards; x already times the aspect). */
  zoom(factor, x = 0, y = 0) {
    const before = this.distance;
    this.distance = Math.min(60 * this.reach, Math.max(1e-4 * this.reach, this.distance * factor));
    const half = Math.tan((FIELD_OF_VIEW / 2) * (Math.PI / 180));
    const shift = (before - this.distance) * half;
    this.target.add(new THREE.Vector3(x * shift, y * shift, 0).applyQuaternion(this.turn));
    this.changed();
  }

  place(aspect) {
    const { camera } = this;
    camera.aspect = aspect;
    camera.position.set(0, 0, this.distance).applyQuaternion(this.turn).add(this.target);
    camera.quaternion.copy(this.turn);
    const depth = this.target.length() + 1.1 * this.reach;
    camera.near = Math.max(this.distance - depth, this.distance * 1e-2, 1e-5);
    camera.far = this.distance + depth;
    camera.updateProjectionMatrix();
    camera.updateMatrixWorld();
    return camera;
  }

  /** Listens to a canvas; `paneAt(event)` says where in which pane, `click(event)` is told of presses that did not move. */
  listen(canvas, paneAt, click) {
    const pointers = new Map();
    let moved = 0;
    const gap = () => {
      const [a, b] = [...pointers.values()];
      return { length: Math.hypot(a.x - b.x, a.y - b.y), x: (a.x + b.x) / 2, y: (a.y + b.y) / 2 };
    };
    canvas.addEventListener('pointerdown', (e) => {
      canvas.setPointerCapture(e.pointerId);
      pointers.set(e.pointerId, { x: e.clientX, y: e.clientY, button: e.button });
      if (pointers.size === 1) moved = 0;
    });
    canvas.addEventListener('pointermove', (e) => {
      const p = pointers.get(e.pointerId);
      if (!p) return;
      const [dx, dy] = [e.clientX - p.x, e.clientY - p.y];
      moved += Math.abs(dx) + Math.abs(dy);
      const height = paneAt(e).height;
      if (pointers.size === 2) {
        const before = gap();
        Object.assign(p, { x: e.clientX, y: e.clientY });
        const after = gap();
        this.pan((after.x - before.x) / height, (after.y - before.y) / height);
        this.zoom(before.length / Math.max(1, after.length));
        return;
      }
      Object.assign(p, { x: e.clientX, y: e.clientY });
      if (moved < 4) return;
      if (p.button !== 0 || e.shiftKey || e.ctrlKey) this.pan(dx / height, dy / height);
      else this.rotate((4 * dx) / height, (4 * dy) / height);
    });
    const up = (e) => {
      const p = pointers.get(e.pointerId);
      pointers.delete(e.pointerId);
      if (p && moved < 4 && p.button === 0 && e.type === 'pointerup') click(e);
    };
    canvas.addEventListener('pointerup', up);
    canvas.addEventListener('pointercancel', up);
    canvas.addEventListener('contextmenu', (e) => e.preventDefault());
    canvas.addEventListener('wheel', (e) => {
      e.preventDefault();
      const pane = paneAt(e);
      const step = e.deltaY * (e.deltaMode === 1 ? 16 : 1);
      this.zoom(Math.exp(Math.max(-0.5, Math.min(0.5, step * 0.0015))), pane.x * pane.aspect, pane.y);
    }, { passive: false });
  }
}
