// Keys and hints.
import { h } from './dom.js';

const KEYS = [
  ['drag', 'turn'], ['right drag, Shift + drag', 'move'], ['wheel, + −', 'zoom, towards the pointer'], ['click', 'numbers of an element'],
  ['arrows', 'turn'], ['f', 'show everything'], ['x y z', 'look along an axis; with Shift from the other side'],
  ['v', 'single, side by side, split'], ['c, Shift + c', 'next, previous colours'], ['1 … 9', 'colours by their place in the list'],
  ['e', 'sides of the elements'], ['s', 'sharp edges'], ['b', 'region borders'],
  ['k', 'skeleton'], ['m', 'motorcycle graph'], ['l', 'slice: off, x, y, z'], ['[ ]', 'move the slice'], [', .', 'smaller, larger cells'],
  ['n, p', 'next, previous of the worst elements'], ['t', 'light, dark'], ['h', 'panel'], ['Esc', 'nothing picked, no help'], ['?', 'this help'],
];

export class Help {
  constructor() {
    this.element = h('dialog', { id: 'help', 'aria-label': 'Help' },
      h('div', { class: 'title' }, h('h2', {}, 'Keys'), h('button', { type: 'button', onclick: () => this.element.close(), 'aria-label': 'Close' }, '×')),
      h('table', {}, h('tbody', {}, KEYS.map(([keys, what]) => h('tr', {}, h('th', { scope: 'row' }, h('kbd', {}, keys)), h('td', {}, what))))));
  }

  toggle() {
    if (this.element.open) this.element.close();
    else this.element.showModal();
  }
}
