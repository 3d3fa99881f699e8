// The viewer of carreau's pages: reads the page's own data and shows it.
import './style.css';
import { App } from './app.js';
import { readPage } from './decode.js';
import { h } from './dom.js';

const wait = h('p', { id: 'wait' }, 'Reading the models …');
document.body.append(wait);

async function start() {
  const page = await readPage();
  // Before the drawing is fitted: it takes the place of the text.
  wait.hidden = true;
  // For tests and for the curious.
  window.carreau = new App(page);
  wait.remove();
  document.documentElement.dataset.ready = 'true';
}

start().catch((error) => {
  console.error(error);
  wait.textContent = `This page cannot be shown: ${error.message}`;
  wait.className = 'failed';
  wait.hidden = false;
});
