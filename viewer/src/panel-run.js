// The run that made the page: command, warnings, figures, timings, options.
import { clear, h } from './dom.js';
import { grouped, number } from './model.js';

export class RunPanel {
  constructor(app) {
    this.app = app;
    const { command, record, carreau } = app.head;
    const copy = h('button', { type: 'button', onclick: () => this.copy(copy, command) }, 'Copy');
    const r = record ?? {};
    const known = ['carreau', 'verb', 'input', 'output', 'options', 'seconds', 'quality', 'warnings'];
    const others = Object.fromEntries(Object.entries(r).filter(([name]) => !known.includes(name)));
    this.element = h('div', {},
      command && h('section', {}, h('div', { class: 'title' }, h('h2', {}, 'Command'), copy), h('pre', { id: 'command' }, command)),
      r.warnings && this.warnings(r.warnings),
      this.part('Input', r.input),
      this.part('Output', r.output),
      this.part('Quality', r.quality),
      this.part('Result', others),
      r.seconds && this.seconds(r.seconds),
      this.part('Options', r.options),
      h('p', { class: 'hint' }, `Made by carreau ${carreau}. This file needs neither network nor server.`));
  }

  copy(button, text) {
    navigator.clipboard?.writeText(text).then(() => { button.textContent = 'Copied'; }, () => { button.textContent = 'Not allowed'; });
  }

  update() {}

  warnings(list) {
    return h('section', {}, h('h2', {}, list.length > 0 ? `Warnings (${list.length})` : 'No warnings'),
      list.length > 0 && h('ul', { class: 'warnings' }, list.slice(0, 200).map((w) => h('li', {}, w))));
  }

  part(title, values) {
    const rows = flat(values ?? {});
    return rows.length > 0 && h('section', {}, h('h2', {}, title), h('table', {}, h('tbody', {},
      rows.map(([name, value]) => h('tr', {}, h('th', { scope: 'row' }, name.replaceAll('_', ' ')), h('td', {}, value))))));
  }

  /** Stages with bars. */
  seconds(seconds) {
    const stages = Object.entries(seconds).filter(([name]) => name !== 'total');
    const most = Math.max(seconds.total ?? 0, ...stages.map(([, s]) => s), 1e-9);
    const row = ([name, s]) => h('tr', {}, h('th', { scope: 'row' }, name),
      h('td', {}, h('span', { class: 'bar', style: `--share:${s / most}` }, `${s < 0.01 ? s.toFixed(4) : s.toFixed(2)} s`)));
    return h('section', {}, h('h2', {}, `Seconds: ${number(seconds.total ?? 0, 4)}`), h('table', { class: 'seconds' }, h('tbody', {}, stages.map(row))));
  }
}

/** Names and values of nested objects, in rows. */
function flat(value, name = '') {
  if (value !== null && typeof value === 'object' && !Array.isArray(value)) {
    return Object.entries(value).flatMap(([key, inner]) => flat(inner, name ? `${name}.${key}` : key));
  }
  if (Array.isArray(value)) return [[name, value.length > 12 ? `${grouped(value.length)} entries` : value.map(text).join(', ') || 'none']];
  return [[name, text(value)]];
}

function text(value) {
  if (typeof value === 'number') return number(value, 6);
  if (value === null) return 'auto';
  return typeof value === 'object' ? JSON.stringify(value) : String(value);
}
