// What the browser tests need: the command, a browser, pages made by the one and opened in the other.
import { execFileSync } from 'node:child_process';
import { existsSync, mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { delimiter, join } from 'node:path';
import { pathToFileURL } from 'node:url';
import { chromium } from 'playwright-core';

const BROWSERS = ['chromium', 'chromium-browser', 'google-chrome', 'google-chrome-stable'];
/** Software drawing: machines without a display and a graphics card draw the same. */
const FLAGS = ['--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--ignore-gpu-blocklist'];

/** A Chromium of the machine, or null, said aloud; with CI=true its absence is a failure. */
export function findBrowser() {
  const folders = (process.env.PATH ?? '').split(delimiter);
  const found = process.env.CHROMIUM ?? BROWSERS.flatMap((name) => folders.map((f) => join(f, name))).find(existsSync);
  if (found) return found;
  if (process.env.CI === 'true') throw new Error('no Chromium on the PATH (apt install chromium, or set CHROMIUM)');
  console.error('SKIPPED: no Chromium on the PATH (apt install chromium, or set CHROMIUM)');
  return null;
}

/** The command under test: CARREAU, or the newest way it was built. */
function findCarreau() {
  const target = process.env.CARGO_TARGET_DIR ?? new URL('../../target', import.meta.url).pathname;
  const found = process.env.CARREAU ?? ['release', 'debug'].map((kind) => join(target, kind, 'carreau')).find(existsSync);
  if (!found) throw new Error('carreau is not built: cargo build --release, or set CARREAU');
  return found;
}

/** A folder of files made by the command, and a browser to open them in. */
export class Bench {
  static async open(executablePath) {
    const bench = new Bench();
    bench.folder = mkdtempSync(join(tmpdir(), 'carreau-page-'));
    bench.command = findCarreau();
    bench.browser = await chromium.launch({ executablePath, args: FLAGS });
    return bench;
  }

  at(name) {
    return join(this.folder, name);
  }

  run(...words) {
    execFileSync(this.command, [...words, '-q'], { cwd: this.folder, stdio: ['ignore', 'ignore', 'inherit'] });
  }

  /** Opens a page and waits until it is drawn; `troubles` collects errors and requests that leave the file. */
  async page(file, { hash = '', colorScheme = 'light', viewport = { width: 1366, height: 768 } } = {}) {
    const page = await this.browser.newPage({ viewport, colorScheme });
    page.setDefaultTimeout(180_000);
    page.troubles = [];
    // What the driver says of the speed of reading pixels is about the machine and the test, not about the page.
    const isTrouble = (m) => ['error', 'warning'].includes(m.type()) && !/GL Driver Message \(OpenGL, Performance/.test(m.text());
    page.on('console', (m) => isTrouble(m) && page.troubles.push(m.text()));
    page.on('pageerror', (e) => page.troubles.push(e.message));
    page.on('request', (r) => !/^(file|data|blob):/.test(r.url()) && page.troubles.push(`asked for ${r.url()}`));
    await page.goto(pathToFileURL(this.at(file)) + hash);
    await page.waitForSelector('html[data-ready]', { state: 'attached' });
    return page;
  }

  async close() {
    await this.browser.close();
    rmSync(this.folder, { recursive: true });
  }
}

/** The drawing as the viewer's canvas has it: a fingerprint, the number of colours, the share that is not background. */
export function drawing(page) {
  return page.evaluate(() => {
    const { stage } = window.carreau;
    stage.draw();
    const gl = stage.renderer.getContext();
    const [w, h] = [gl.drawingBufferWidth, gl.drawingBufferHeight];
    const pixels = new Uint32Array(w * h);
    gl.readPixels(0, 0, w, h, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(pixels.buffer));
    const background = pixels[0];
    let [print, drawn] = [0, 0];
    for (const p of pixels) {
      print = (Math.imul(print, 31) + p) | 0;
      if (p !== background) drawn += 1;
    }
    return { print, colors: new Set(pixels).size, drawn: drawn / pixels.length, background: background & 0xff };
  });
}

/** The number of colours in a screenshot. */
export async function colorsOf(page) {
  const png = (await page.screenshot()).toString('base64');
  return page.evaluate(async (text) => {
    const image = new Image();
    image.src = `data:image/png;base64,${text}`;
    await image.decode();
    const canvas = new OffscreenCanvas(image.width, image.height);
    const context = canvas.getContext('2d');
    context.drawImage(image, 0, 0);
    return new Set(new Uint32Array(context.getImageData(0, 0, image.width, image.height).data.buffer)).size;
  }, png);
}

/** Rows of the card of the picked element: names to values. */
export function card(page) {
  return page.evaluate(() => ({
    title: document.querySelector('#picked h2')?.textContent ?? null,
    rows: Object.fromEntries(Array.from(document.querySelectorAll('#picked table:not(.corners) tr'), (r) => [r.cells[0].textContent, r.cells[1].textContent])),
    corners: Array.from(document.querySelectorAll('#picked .corners tr'), (r) => [Number(r.cells[0].textContent), r.cells[1].textContent.split(', ').map(Number)]),
  }));
}

/** Clicks where a point of a model (local coordinates) is drawn. */
export async function clickAt(page, pane, local) {
  const [x, y] = await page.evaluate(([k, p]) => {
    const { stage, canvas } = window.carreau;
    const box = canvas.getBoundingClientRect();
    const [sx, sy] = stage.screenOf(stage.panes[k].model, p);
    return [box.left + sx, box.top + sy];
  }, [pane, local]);
  await page.mouse.click(x, y);
}
