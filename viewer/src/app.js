// The page: state, stage and panels, tied together.
import { h } from './dom.js';
import { Header } from './header.js';
import { Help } from './help.js';
import { listenToKeys } from './keyboard.js';
import { Model } from './model.js';
import { LayersPanel } from './panel-layers.js';
import { QualityPanel } from './panel-quality.js';
import { RunPanel } from './panel-run.js';
import { PaneBars } from './panes.js';
import { PickedCard } from './picked.js';
import { Sidebar } from './sidebar.js';
import { Stage } from './stage.js';
import { State } from './state.js';
import { themeOf } from './theme.js';

/** Overlays that are drawn unless switched off. */
const SHOWN = ['region', 'border', 'feature', 'track', 'field', 'marks'];
/** Opacity of a surface around a skeleton. */
const GLASS = 0.45;

export class App {
  constructor({ head, read }) {
    this.head = head;
    this.read = read;
    this.models = new Map();
    const ramps = { sequential: read(head.ramps.sequential), diverging: read(head.ramps.diverging) };
    this.ramps = ramps;
    this.state = new State(this.start());
    this.theme = themeOf(this.state.theme);

    this.canvas = h('canvas', { id: 'canvas', tabindex: 0, 'aria-label': 'The models; arrow keys turn them, ? lists all keys' });
    this.viewport = h('main', { id: 'viewport' }, this.canvas);
    this.help = new Help();
    this.header = new Header(this);
    this.panes = new PaneBars(this);
    this.card = new PickedCard(this);
    this.quality = new QualityPanel(this);
    this.sidebar = new Sidebar(this, {
      layers: ['Layers', new LayersPanel(this)],
      quality: ['Quality', this.quality],
      run: ['Run', new RunPanel(this)],
    });
    this.body = h('div', { id: 'body' }, this.viewport, this.sidebar.element);
    document.body.append(this.header.element, this.body, this.help.element);
    this.viewport.append(this.panes.element);

    this.stage = new Stage(this.canvas, ramps);
    this.stage.onpick = (pick) => this.state.set({ picked: pick });
    listenToKeys(this);
    matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => this.apply(new Set(['theme'])));
    this.state.listen((changed) => this.apply(changed));
    this.apply(new Set(['left', 'right', 'layout', 'theme', 'tab', 'sidebar']));
    const solid = this.shown().find((m) => m.faces.count > 0 || m.isVolume) ?? this.shown()[0];
    const { eye, up } = solid ?? { eye: [0, -1, 0.4], up: [0, 0, 1] };
    this.stage.orbit.lookFrom(eye, up);
    this.home = { eye, up };
    this.stage.resize();
    this.stage.fit();
  }

  /** The first state: what the address asks for, else before and after side by side. */
  start() {
    const { scenes } = this.head;
    const asked = new URLSearchParams(location.hash.slice(1));
    const named = (key) => scenes.findIndex((s) => s.name === asked.get(key));
    const oneOf = (key, known, otherwise) => (known.includes(asked.get(key)) ? asked.get(key) : otherwise);
    const of = (role) => scenes.findIndex((s) => s.role === role);
    const first = [named('left'), of('before'), 0].find((k) => k >= 0);
    const second = [named('right'), of('after'), scenes.length > 1 ? (first === 1 ? 0 : 1) : -1].find((k) => k >= 0 && k !== first) ?? null;
    return {
      left: first,
      right: second,
      layout: oneOf('layout', ['single', 'side', 'split'], second === null ? 'single' : 'side'),
      split: 0.5,
      tab: oneOf('tab', ['layers', 'quality', 'run'], 'layers'),
      theme: oneOf('theme', ['light', 'dark'], 'auto'),
      sidebar: true,
      colours: {},
      overlays: Object.fromEntries(SHOWN.map((kind) => [kind, true])),
      angle: 35,
      edges: true,
      smooth: true,
      opacity: null,
      axis: 'off',
      at: 0.5,
      flip: false,
      shrink: 1,
      measure: 'quality',
      keep: null,
      stretch: false,
      picked: null,
    };
  }

  model(index) {
    if (!this.models.has(index)) this.models.set(index, new Model(this.head.scenes[index], this.read, index));
    return this.models.get(index);
  }

  /** The models that are drawn, left to right. */
  shown() {
    const { left, right, layout } = this.state;
    if (this.head.scenes.length === 0) return [];
    return right === null || layout === 'single' ? [this.model(left)] : [this.model(left), this.model(right)];
  }

  /** The layer that colours a model; null is plain. */
  colourOf(model) {
    return model.layerNamed(this.state.colours[model.index] ?? model.show) ?? null;
  }

  /** Colours a model by a layer, and the other one by its layer of that name. */
  colourBy(model, name) {
    const colours = { ...this.state.colours, [model.index]: name };
    for (const other of this.shown()) {
      if (other !== model && (name === 'plain' || other.layerNamed(name))) colours[other.index] = name;
    }
    this.state.set({ colours });
  }

  /** The numbers that the colours of a layer span: quality 0 to 1, or stretched over what the models have. */
  rangeOf(layer) {
    if (layer.range !== 'quality' || !this.state.stretch) return [layer.stats.low, layer.stats.high];
    const lows = this.shown().map((m) => m.quality?.stats.p02 ?? 1);
    return [Math.min(0.99, ...lows), 1];
  }

  /** The layer of numbers that is measured, of one model. */
  measureOf(model) {
    const layer = model.layerNamed(this.state.measure);
    return layer?.kind === 'scalar' ? layer : model.quality ?? null;
  }

  toggle(kind) {
    this.state.set({ overlays: { ...this.state.overlays, [kind]: !this.overlayOn(kind) } });
  }

  /**
   * Whether an overlay is shown: as chosen; else sharp edges unless there are too many, a skeleton unless it is inside
   * cells, its radii where there is nothing else.
   */
  overlayOn(kind, models = this.shown()) {
    const chosen = this.state.overlays[kind];
    if (chosen !== undefined) return chosen;
    if (kind === 'sharp') return models.every((m) => m.isVolume || m.faces.count === 0 || this.stage.actor(m).overlays.sharpIsClear);
    if (kind === 'skeleton') return models.some((m) => m.nets.length > 0 && !m.isVolume);
    if (kind === 'tube') return models.some((m) => m.nets.length > 0 && m.faces.count === 0 && m.cells.count === 0);
    return false;
  }

  opacityOf(model) {
    return this.state.opacity ?? (model.nets.length > 0 && model.faces.count > 0 && !model.isVolume ? GLASS : 1);
  }

  apply(changed) {
    const { state, stage } = this;
    if (changed.has('theme')) {
      this.theme = themeOf(state.theme);
      document.documentElement.dataset.theme = this.theme.name;
      stage.background = this.theme.background;
    }
    if (['left', 'right', 'layout'].some((name) => changed.has(name))) {
      stage.layout = this.shown().length < 2 ? 'single' : state.layout;
      stage.show(this.shown());
      stage.refit();
      if (state.picked && !this.shown().includes(state.picked.model)) {
        state.values.picked = null;
        changed.add('picked');
      }
    }
    stage.split = state.split;
    stage.shrink = state.shrink;
    stage.slice = this.slicePlane();
    stage.panes.forEach((pane) => this.applyTo(pane));
    this.header.update(changed);
    this.panes.update(changed);
    this.sidebar.update(changed);
    this.card.update(changed);
    stage.redraw();
  }

  applyTo(pane) {
    const { state, theme, stage } = this;
    const { model, skin, overlays } = pane;
    const layer = this.colourOf(model);
    if (skin.layer !== layer) skin.paint(layer);
    skin.theme(theme);
    const { material } = skin;
    const strength = theme.name === 'dark' ? 0.62 : 0.5;
    // Frames and tracks are hard to see among the sides of triangles.
    const isHidden = (kind) => overlays.kinds().includes(kind) && this.overlayOn(kind) && model.kindOf('face', 0) === 'triangle';
    const faint = isHidden('field') || isHidden('track') ? 0.25 : 1;
    material.uniforms.lines.value = state.edges ? strength * faint : 0;
    material.uniforms.flatFaces.value = !state.smooth || model.isVolume;
    skin.opacity = this.opacityOf(model);
    if (layer?.kind === 'scalar') material.uniforms.range.value.set(...this.rangeOf(layer));
    const labels = layer?.kind === 'label' && layer.on === 'face' ? layer : null;
    const options = { angle: state.angle, labels };
    for (const kind of overlays.kinds()) overlays.set(kind, this.overlayOn(kind, [model]), options, theme);
    overlays.theme(theme);
    pane.netsShown = model.nets.length > 0 && this.overlayOn('skeleton', [model]);
    overlays.outline(state.picked?.model === model ? state.picked : null, theme, state.shrink);
    stage.cut(pane, this.measureOf(model), state.keep);
  }

  /** The plane of the slice in the frame of the world. */
  slicePlane() {
    const { axis, at, flip } = this.state;
    if (axis === 'off') return null;
    const k = 'xyz'.indexOf(axis);
    let [low, high] = [Infinity, -Infinity];
    for (const { model, frame } of this.stage.panes) {
      const [a, b] = this.extentAlong(model, k);
      low = Math.min(low, a * frame.s + frame.t[k]);
      high = Math.max(high, b * frame.s + frame.t[k]);
    }
    const n = [0, 0, 0];
    n[k] = flip ? -1 : 1;
    const place = low + at * (high - low);
    return { n, d: flip ? -place : place };
  }

  extentAlong(model, k) {
    return model.once(`extent ${k}`, () => {
      let [low, high] = [Infinity, -Infinity];
      for (const points of [model.points, ...model.nets.map((n) => n.points)]) {
        for (let c = k; c < points.length; c += 3) {
          low = Math.min(low, points[c]);
          high = Math.max(high, points[c]);
        }
      }
      return [low, high];
    });
  }

  /** Picks an element and moves the camera there. */
  visit(model, on, id) {
    const extent = on === 'vertex' ? { middle: model.local(id), reach: 0.01 } : model.extent(on, id);
    this.stage.goTo(model, extent);
    const picked = on === 'vertex' ? this.faceOfVertex(model, id) : { on, id, face: id };
    if (picked) this.state.set({ picked: { ...picked, model, point: extent.middle, pane: this.shown().indexOf(model) } });
  }

  faceOfVertex(model, v) {
    const list = model.isVolume ? model.cells : model.faces;
    const c = list.corners.indexOf(v);
    if (c < 0) return null;
    let id = 0;
    while (list.offsets[id + 1] <= c) id++;
    return { on: model.isVolume ? 'cell' : 'face', id, face: id };
  }

  goHome() {
    this.stage.orbit.lookFrom(this.home.eye, this.home.up);
    this.stage.fit();
  }
}
