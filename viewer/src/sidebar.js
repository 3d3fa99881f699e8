// The panel at the side: tabs, and the picked element below.
import { h } from './dom.js';

export class Sidebar {
  constructor(app, panels) {
    this.app = app;
    this.panels = panels;
    this.tabs = Object.fromEntries(Object.entries(panels).map(([key, [title]]) => [key, h('button', {
      type: 'button', role: 'tab', id: `tab-${key}`, 'aria-controls': `panel-${key}`,
      onclick: () => app.state.set({ tab: key }), onkeydown: (e) => this.arrows(e, key),
    }, title)]));
    this.boxes = Object.fromEntries(Object.entries(panels).map(([key, [, panel]]) => [key, h('div', {
      role: 'tabpanel', id: `panel-${key}`, 'aria-labelledby': `tab-${key}`, class: 'panel',
    }, panel.element)]));
    this.element = h('aside', { id: 'sidebar', 'aria-label': 'Layers, quality, run' },
      h('div', { role: 'tablist', class: 'tabs' }, Object.values(this.tabs)), Object.values(this.boxes), app.card.element);
  }

  arrows(event, key) {
    const keys = Object.keys(this.tabs);
    const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (!step) return;
    event.stopPropagation();
    const next = keys[(keys.indexOf(key) + step + keys.length) % keys.length];
    this.app.state.set({ tab: next });
    this.tabs[next].focus();
  }

  update(changed) {
    const { tab, sidebar } = this.app.state;
    this.element.hidden = !sidebar;
    for (const key of Object.keys(this.tabs)) {
      this.tabs[key].setAttribute('aria-selected', String(key === tab));
      this.tabs[key].tabIndex = key === tab ? 0 : -1;
      this.boxes[key].hidden = key !== tab;
    }
    this.panels[tab][1].update(changed);
  }
}
