// The numbers of the picked element.
import { clear, h } from './dom.js';
import { number, valueText } from './model.js';

export class PickedCard {
  constructor(app) {
    this.app = app;
    this.element = h('section', { id: 'picked', 'aria-live': 'polite', 'aria-label': 'Picked element' });
  }

  update(changed) {
    if (!changed.has('picked') && this.element.childElementCount > 0) return;
    const pick = this.app.state.picked;
    if (!pick) clear(this.element, h('p', { class: 'hint' }, 'Click an element to see its numbers.'));
    else clear(this.element, pick.on === 'node' ? this.node(pick) : this.face(pick));
  }

  title(text, pick) {
    const visit = () => this.app.visit(pick.model, pick.on, pick.id);
    return h('div', { class: 'title' }, h('h2', {}, text),
      pick.on !== 'node' && h('button', { type: 'button', onclick: visit, title: 'Move the camera there' }, 'Zoom'),
      h('button', { type: 'button', onclick: () => this.app.state.set({ picked: null }), 'aria-label': 'Close', title: 'Close (Esc)' }, '×'));
  }

  face(pick) {
    const { model, on, id } = pick;
    const rows = model.layers.filter((l) => l.on === on).map((l) => [l.name, valueText(l, id)]);
    if (on === 'cell' && pick.face >= 0) {
      rows.push(...model.layers.filter((l) => l.on === 'face').map((l) => [`${l.name} of the face`, valueText(l, pick.face)]));
    }
    const corners = Array.from(model.corners(on, id));
    const nearest = this.nearest(model, corners, pick.point);
    return [
      this.title(`${on === 'cell' ? 'Cell' : 'Face'} ${id}: ${model.kindOf(on, id)}`, pick),
      h('p', { class: 'scene' }, model.name),
      table([...rows, ['clicked at', model.pointText(pick.point)]]),
      h('h3', {}, 'Corners'),
      table(corners.map((v) => [v, model.pointText(model.local(v))]), 'corners'),
      this.vertexRows(model, nearest),
    ];
  }

  nearest(model, corners, point) {
    const away = (v) => Math.hypot(...model.local(v).map((x, k) => x - point[k]));
    return corners.reduce((best, v) => (away(v) < away(best) ? v : best), corners[0]);
  }

  vertexRows(model, v) {
    const rows = model.layers.filter((l) => l.on === 'vertex').map((l) => [l.name, valueText(l, v)]);
    for (const m of model.markers) {
      m.vertices.forEach((w, k) => {
        if (w === v) rows.push([m.name, `${m.values[k]} quads, usual ${m.usual[k]}`]);
      });
    }
    return rows.length > 0 && [h('h3', {}, `Nearest vertex, ${v}`), table(rows)];
  }

  node(pick) {
    const net = pick.model.nets[pick.net];
    const valence = net.edges.reduce((sum, v) => sum + (v === pick.id), 0);
    const radius = pick.radius * pick.model.scale;
    return [
      this.title(`Node ${net.ids[pick.id]}`, pick),
      h('p', { class: 'scene' }, `${net.name} of ${pick.model.name}`),
      table([['radius', number(radius)], ['segments', valence], ['at', pick.model.pointText(pick.point)]]),
    ];
  }
}

const table = (rows, kind = '') => h('table', { class: kind }, h('tbody', {}, rows.map(([name, value]) => h('tr', {}, h('th', { scope: 'row' }, String(name)), h('td', {}, String(value))))));
