// Distribution of a layer of numbers, its extreme elements, and the range that is shown.
import { clear, h, select, slider } from './dom.js';
import { binsOf, drawHistogram, extremes } from './histogram.js';
import { grouped, number } from './model.js';

const LISTED = 12;

export class QualityPanel {
  constructor(app) {
    this.app = app;
    this.element = h('div');
    this.visited = -1;
  }

  update(changed) {
    const relevant = ['left', 'right', 'layout', 'measure', 'theme', 'tab', 'sidebar'];
    if (relevant.some((name) => changed.has(name))) this.build();
    else if (changed.has('keep')) {
      // A slider that is being dragged stays.
      if (document.activeElement?.type === 'range' && this.element.contains(document.activeElement)) this.refresh();
      else this.build();
    }
  }

  layers() {
    const names = new Set();
    for (const model of this.app.shown()) model.layers.filter((l) => l.kind === 'scalar').forEach((l) => names.add(l.name));
    return [...names];
  }

  build() {
    const { app } = this;
    const names = this.layers();
    if (names.length === 0) {
      clear(this.element, h('p', { class: 'hint' }, 'There are no numbers on these models.'));
      return;
    }
    const current = names.includes(app.state.measure) ? app.state.measure : names.includes('quality') ? 'quality' : names[0];
    const choose = (measure) => app.state.set({ measure, keep: null });
    this.charts = [];
    clear(this.element,
      h('section', {}, h('label', { class: 'row' }, h('span', {}, 'Measure'), select('Measure', names.map((n) => [n, n]), current, choose, 'measure')),
        current === 'quality' && h('p', { class: 'hint' }, 'Triangles: mean ratio. Quads and hexahedra: scaled Jacobian. 1 is perfect, 0 and below invalid.'),
        this.range(current)),
      app.shown().map((model) => this.chart(model, model.layerNamed(current))));
    // Sizes are known once the panel is laid out.
    requestAnimationFrame(() => this.refresh());
  }

  /** Two sliders for the values that are shown. */
  range(name) {
    const { app } = this;
    const layers = app.shown().map((m) => m.layerNamed(name)).filter((l) => l?.kind === 'scalar');
    const low = Math.min(...layers.map((l) => l.stats.min));
    const high = Math.max(...layers.map((l) => l.stats.max));
    if (!(high > low)) return null;
    const [from, to] = app.state.keep ?? [low, high];
    const text = (x) => number(x * layers[0].unit, 3);
    const step = (high - low) / 400;
    const set = (at, value) => {
      const now = [...(app.state.keep ?? [low, high])];
      now[at] = value;
      const all = now[0] <= low && now[1] >= high - step / 2;
      app.state.set({ keep: all ? null : now });
    };
    return [
      slider('Show from', { min: low, max: high, step, value: from, text }, (x) => set(0, x), { id: 'keep-from' }),
      slider('up to', { min: low, max: high, step, value: to, text }, (x) => set(1, x >= high - step ? Infinity : x), { id: 'keep-to' }),
    ];
  }

  chart(model, layer) {
    if (layer?.kind !== 'scalar') return null;
    const { app } = this;
    const bins = model.once(`bins ${layer.name}`, () => binsOf(layer));
    const canvas = h('canvas', { class: 'histogram', 'data-scene': model.name, role: 'img',
      'aria-label': `Histogram of ${layer.name} of ${model.name}`,
      onclick: (e) => this.isolate(layer, bins, (e.clientX - canvas.getBoundingClientRect().left) / canvas.clientWidth),
      onpointermove: (e) => this.tell(note, layer, bins, (e.clientX - canvas.getBoundingClientRect().left) / canvas.clientWidth),
      onpointerleave: () => { note.textContent = '\u00a0'; } });
    const note = h('p', { class: 'hint' }, '\u00a0');
    this.charts.push({ canvas, layer, bins });
    const text = (x) => number(x * layer.unit, 4);
    const { stats } = layer;
    const highest = layer.range !== 'quality';
    const worst = model.once(`extremes ${layer.name}`, () => extremes(layer, LISTED, highest));
    const ends = h('div', { class: 'ends' }, h('span', {}, text(bins.low)), h('span', {}, text(bins.high)));
    return h('section', {},
      h('h2', {}, model.name),
      canvas, ends, note,
      h('p', { class: 'figures' }, `min ${text(stats.min)} · mean ${text(stats.mean)} · max ${text(stats.max)} · ${grouped(stats.count)} ${plural(layer.on)}`),
      h('h3', {}, highest ? 'Highest' : 'Worst'),
      h('div', { class: 'worst' }, worst.map((id) => h('button', {
        type: 'button', title: `${layer.on} ${id}: move the camera there`, onclick: () => app.visit(model, layer.on, id),
      }, h('b', {}, text(layer.values[id])), h('small', {}, `${layer.on} ${id}`)))));
  }

  /** Shows only the elements of one bar; a second click shows all. */
  isolate(layer, bins, share) {
    const width = (bins.high - bins.low) / bins.counts.length;
    const k = Math.min(bins.counts.length - 1, Math.floor(share * bins.counts.length));
    const range = [k === 0 ? -Infinity : bins.low + k * width, k === bins.counts.length - 1 ? Infinity : bins.low + (k + 1) * width];
    const same = this.app.state.keep?.every((x, i) => x === range[i]);
    this.app.state.set({ keep: same ? null : range });
  }

  tell(note, layer, bins, share) {
    const width = (bins.high - bins.low) / bins.counts.length;
    const k = Math.max(0, Math.min(bins.counts.length - 1, Math.floor(share * bins.counts.length)));
    const text = (x) => number(x * layer.unit, 3);
    note.textContent = `${text(bins.low + k * width)} to ${text(bins.low + (k + 1) * width)}: ${grouped(bins.counts[k])} ${plural(layer.on)}`;
  }

  refresh() {
    const { app } = this;
    const ink = { rule: getComputedStyle(document.documentElement).getPropertyValue('--rule'), invalid: app.theme.invalid };
    for (const { canvas, layer, bins } of this.charts ?? []) {
      const ramp = layer.range === 'diverging' ? app.ramps.diverging : app.ramps.sequential;
      drawHistogram(canvas, layer, ramp, bins, app.state.keep, ink);
    }
  }

  /** The next of the worst elements of the last model shown. */
  next(step) {
    const model = this.app.shown().at(-1);
    const layer = model && this.app.measureOf(model);
    if (!layer) return;
    const worst = model.once(`extremes ${layer.name}`, () => extremes(layer, LISTED, layer.range !== 'quality'));
    this.visited = (this.visited + step + worst.length) % worst.length;
    this.app.visit(model, layer.on, worst[this.visited]);
  }
}

const plural = (on) => ({ vertex: 'vertices', face: 'faces', cell: 'cells' })[on];
