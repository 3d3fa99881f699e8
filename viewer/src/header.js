// The bar at the top: title, layout, view, theme, help.
import { h, clear, segmented } from './dom.js';

export class Header {
  constructor(app) {
    this.app = app;
    this.layout = h('span');
    this.theme = h('span');
    const { head } = app;
    this.element = h('header', {},
      h('h1', {}, head.title),
      h('span', { class: 'spacer' }),
      this.layout,
      h('button', { type: 'button', title: 'Show everything from the first side (f)', onclick: () => app.goHome() }, 'Fit'),
      this.theme,
      h('button', { type: 'button', title: 'Show or hide the panel (h)', onclick: () => app.state.set({ sidebar: !app.state.sidebar }) }, 'Panel'),
      h('button', { type: 'button', title: 'Keys and hints (?)', 'aria-label': 'Help', onclick: () => app.help.toggle() }, '?'));
  }

  update() {
    const { state, head } = this.app;
    const layouts = [['single', 'Single', 'One model (v)'], ['side', 'Side by side', 'Two models (v)'], ['split', 'Split', 'Two models over each other, with a slider (v)']];
    clear(this.layout, head.scenes.length > 1 && segmented('Layout', layouts, state.layout, (layout) => this.app.state.set({ layout })));
    const themes = [['auto', 'Auto', 'Follow the system'], ['light', 'Light', 'Light (t)'], ['dark', 'Dark', 'Dark (t)']];
    clear(this.theme, segmented('Theme', themes, state.theme, (theme) => state.set({ theme })));
  }
}
