// What is drawn: overlays, faces, slice.
import { checkbox, clear, h, segmented, slider } from './dom.js';
import { KINDS } from './overlays.js';

export class LayersPanel {
  constructor(app) {
    this.app = app;
    this.element = h('div');
  }

  update(changed) {
    // Sliders that are being dragged stay.
    if (this.element.contains(document.activeElement) && document.activeElement.type === 'range' && !changed.has('axis')) return;
    clear(this.element, this.overlays(), this.faces(), this.slice());
  }

  overlays() {
    const { app } = this;
    const panes = app.stage?.panes ?? [];
    const kinds = Object.keys(KINDS).filter((kind) => panes.some((p) => p.overlays.kinds().includes(kind)));
    if (kinds.length === 0) return null;
    const title = (kind) => panes.find((p) => p.overlays.kinds().includes(kind)).overlays.title(kind);
    const color = (kind) => (kind === 'marks' ? `linear-gradient(90deg, ${app.theme.fewer} 50%, ${app.theme.more} 50%)` : app.theme[kind]);
    const item = (kind) => h('li', {},
      checkbox(title(kind), app.overlayOn(kind), () => app.toggle(kind), { 'data-key': kind }),
      h('i', { class: 'swatch', style: `background:${color(kind)}` }));
    const angle = kinds.includes('sharp') && app.overlayOn('sharp')
      ? slider('Sharp from', { min: 5, max: 90, step: 1, value: app.state.angle, text: (x) => `${x}°` }, (angle) => app.state.set({ angle })) : null;
    return h('section', {}, h('h2', {}, 'Lines and marks'), h('ul', { class: 'list' }, kinds.map(item)), angle);
  }

  faces() {
    const { state } = this.app;
    const models = this.app.shown();
    if (!models.some((m) => m.faces.count > 0 || m.isVolume)) return null;
    const opacity = Math.min(...models.map((m) => this.app.opacityOf(m)));
    return h('section', {}, h('h2', {}, 'Faces'),
      checkbox('Sides of the elements', state.edges, (edges) => state.set({ edges }), { 'data-key': 'edges' }),
      models.some((m) => !m.isVolume) && checkbox('Smooth shading', state.smooth, (smooth) => state.set({ smooth }), { 'data-key': 'smooth' }),
      slider('Opacity', { min: 0.05, max: 1, step: 0.05, value: opacity, text: (x) => `${Math.round(100 * x)} %` }, (x) => state.set({ opacity: x })));
  }

  slice() {
    const { state } = this.app;
    const volume = this.app.shown().some((m) => m.isVolume);
    const axes = [['off', 'Off'], ['x', 'x'], ['y', 'y'], ['z', 'z']];
    return h('section', {}, h('h2', {}, 'Slice'),
      h('div', { class: 'row' }, segmented('Axis of the slice', axes, state.axis, (axis) => state.set({ axis })),
        state.axis !== 'off' && checkbox('Other side', state.flip, (flip) => state.set({ flip }), { 'data-key': 'flip' })),
      state.axis !== 'off' && slider('Position', { min: 0, max: 1, step: 0.005, value: state.at, text: (x) => `${Math.round(100 * x)} %` }, (at) => state.set({ at }), { id: 'slice-at' }),
      volume && slider('Cell size', { min: 0.2, max: 1, step: 0.02, value: state.shrink, text: (x) => `${Math.round(100 * x)} %` }, (shrink) => state.set({ shrink }), { id: 'shrink' }),
      volume && h('p', { class: 'hint' }, 'Cells can also be peeled by their values: see Quality.'));
  }
}
