// Over each pane: which scene, coloured by which layer, and the legend. Between two: the slider of the split.
import { checkbox, clear, h, select } from './dom.js';
import { grouped, number } from './model.js';

/** Labels in a legend. */
const MOST_LABELS = 5;

export class PaneBars {
  constructor(app) {
    this.app = app;
    this.bars = [h('section', { class: 'pane left' }), h('section', { class: 'pane right' })];
    this.divider = h('input', {
      id: 'split', type: 'range', min: 0, max: 1, step: 0.001, value: 0.5, 'aria-label': 'Where the two models meet',
      oninput: () => app.state.set({ split: Number(this.divider.value) }),
    });
    this.rule = h('div', { id: 'rule', onpointerdown: (e) => this.drag(e) });
    this.element = h('div', { id: 'panes' }, this.bars, this.rule, this.divider);
  }

  drag(start) {
    this.rule.setPointerCapture(start.pointerId);
    const move = (e) => {
      const box = this.element.getBoundingClientRect();
      this.app.state.set({ split: Math.min(1, Math.max(0, (e.clientX - box.left) / box.width)) });
    };
    this.rule.addEventListener('pointermove', move);
    this.rule.addEventListener('pointerup', () => this.rule.removeEventListener('pointermove', move), { once: true });
  }

  update(changed) {
    const { app } = this;
    const models = app.shown();
    const isSplit = models.length > 1 && app.state.layout === 'split';
    this.element.dataset.layout = models.length > 1 ? app.state.layout : 'single';
    this.divider.hidden = !isSplit;
    this.rule.hidden = !isSplit;
    this.divider.value = app.state.split;
    this.rule.style.left = `${100 * app.state.split}%`;
    if (!['left', 'right', 'layout', 'colours', 'theme', 'stretch'].some((name) => changed.has(name))) return;
    this.bars.forEach((bar, k) => {
      bar.hidden = !models[k];
      if (models[k]) clear(bar, this.chooser(models[k], k), this.legend(models[k], k));
    });
  }

  chooser(model, k) {
    const { app } = this;
    const side = k === 0 ? 'left' : 'right';
    const roles = { before: 'before: ', after: 'after: ', other: '' };
    const scenes = app.head.scenes.map((s, index) => [index, `${app.head.scenes.length > 1 ? roles[s.role] : ''}${s.name}`]);
    const layers = [['plain', 'plain'], ...model.layers.filter((l) => l.kind !== 'vector').map((l) => [l.name, `${l.name}${l.on === 'vertex' ? ' (vertices)' : ''}`])];
    return h('div', { class: 'chooser' },
      select(`Scene ${side}`, scenes, model.index, (index) => app.state.set({ [side]: Number(index) }), `scene-${side}`),
      select(`Colours ${side}`, layers, app.colourOf(model)?.name ?? 'plain', (name) => app.colourBy(model, name), `colour-${side}`),
      h('span', { class: 'counts' }, counts(model)));
  }

  legend(model, k) {
    const layer = this.app.colourOf(model);
    if (!layer || layer.kind === 'vector' || layer.kind === 'color') return null;
    return h('div', { class: 'legend' }, layer.kind === 'scalar' ? this.rampLegend(layer, k) : this.labelLegend(layer));
  }

  rampLegend(layer, pane) {
    const ramp = layer.range === 'diverging' ? this.app.ramps.diverging : this.app.ramps.sequential;
    const stops = Array.from({ length: 17 }, (_, k) => {
      const at = 3 * Math.round((k / 16) * 255);
      return `rgb(${ramp[at]} ${ramp[at + 1]} ${ramp[at + 2]})`;
    });
    const bar = h('div', { class: 'ramp', style: `background: linear-gradient(to right, ${stops.join(', ')})` });
    const text = (x) => number(x * layer.unit, 3);
    const [low, high] = this.app.rangeOf(layer);
    const ends = h('div', { class: 'ends' }, h('span', {}, text(low)), h('b', {}, layer.name), h('span', {}, text(high)));
    const { state } = this.app;
    const stretch = layer.range === 'quality' && checkbox('Stretch', state.stretch, (on) => state.set({ stretch: on }),
      { id: `stretch-${pane}`, title: 'Spread the colours over the values that occur, the same in both panes' });
    const invalid = layer.range === 'quality' && layer.stats.min <= 0
      ? h('div', { class: 'invalid' }, h('i', { style: `background:${this.app.theme.invalid}` }), 'invalid (0 and below)') : null;
    return [bar, ends, stretch, invalid];
  }

  labelLegend(layer) {
    const counted = new Map();
    for (const v of layer.values) counted.set(v, (counted.get(v) ?? 0) + 1);
    const ranks = Array.from(layer.labels, (label, k) => ({ label, k, count: counted.get(label) ?? 0 }));
    ranks.sort((a, b) => b.count - a.count);
    const rest = ranks.length - MOST_LABELS;
    const item = ({ label, k, count }) => h('li', {},
      h('i', { style: `background: rgb(${layer.colors.subarray(3 * k, 3 * k + 3).join(' ')})` }),
      h('span', {}, layer.words[label] ? `${label}: ${layer.words[label]}` : String(label)), h('small', {}, grouped(count)));
    return [h('b', {}, `${layer.name}: ${grouped(ranks.length)}`), h('ul', {}, ranks.slice(0, MOST_LABELS).map(item)),
      rest > 0 ? h('small', {}, `and ${grouped(rest)} more`) : null];
  }
}

function counts(model) {
  const parts = [];
  if (model.cells.count) parts.push(`${grouped(model.cells.count)} cells`);
  else if (model.faces.count) parts.push(`${grouped(model.faces.count)} faces`);
  if (model.vertexCount) parts.push(`${grouped(model.vertexCount)} vertices`);
  const segments = model.nets.reduce((sum, n) => sum + n.edges.length / 2, 0);
  if (segments) parts.push(`${grouped(segments)} segments`);
  return parts.join(' · ');
}
