// The pages in a real browser: they load, draw, switch, and tell the numbers of the mesh.
import assert from 'node:assert/strict';
import { writeFileSync } from 'node:fs';
import { after, before, describe, test } from 'node:test';
import { Bench, card, clickAt, colorsOf, drawing, findBrowser } from './setup.mjs';

const browser = findBrowser();
/** Quads along each side of the sheet, and where it lies: far from the origin. */
const SIDE = 12;
const PLACE = [250_000, -31_000, 4_000];

/** A flat sheet of unit squares, every second one cut into two triangles: faces of both kinds in a known order. */
function sheet() {
  const lines = [];
  const faces = [];
  for (let j = 0; j <= SIDE; j++) {
    for (let i = 0; i <= SIDE; i++) lines.push(`v ${PLACE[0] + i} ${PLACE[1] + j} ${PLACE[2]}`);
  }
  for (let j = 0; j < SIDE; j++) {
    for (let i = 0; i < SIDE; i++) {
      const a = j * (SIDE + 1) + i;
      const quad = [a, a + 1, a + SIDE + 2, a + SIDE + 1];
      faces.push(...((i + j) % 2 ? [quad] : [[quad[0], quad[1], quad[2]], [quad[0], quad[2], quad[3]]]));
    }
  }
  lines.push(...faces.map((f) => `f ${f.map((v) => v + 1).join(' ')}`));
  return { text: lines.join('\n'), faces };
}

describe('pages in a browser', { skip: browser === null }, () => {
  let bench;
  before(async () => { bench = await Bench.open(browser); });
  after(() => bench?.close());

  test('input and result stand side by side and are drawn', async () => {
    bench.run('sample', 'bracket', '-o', 'bracket.ply');
    bench.run('quad', 'bracket.ply', '--quads', '800', '-o', 'quads.obj', '--report', 'quad.html');
    const page = await bench.page('quad.html');
    assert.equal(await page.title(), 'carreau quad bracket.ply');
    assert.deepEqual(await page.evaluate(() => window.carreau.shown().map((m) => [m.name, m.role])), [['bracket.ply', 'before'], ['quads.obj', 'after']]);
    const seen = await drawing(page);
    assert.ok(seen.colors > 200 && seen.drawn > 0.1 && seen.drawn < 0.9, JSON.stringify(seen));
    assert.ok(await colorsOf(page) > 300, 'a screenshot is not blank');
    assert.match(await page.locator('#command').textContent(), /^carreau quad bracket\.ply --quads 800/);
    await page.click('#tab-run');
    assert.match(await page.locator('#panel-run').innerText(), /scaled jacobian min/);
    assert.deepEqual(page.troubles, []);
    await page.close();
  });

  test('layers, overlays and layouts change what is drawn', async () => {
    const page = await bench.page('quad.html');
    const prints = new Set([(await drawing(page)).print]);
    const changed = async (what) => {
      const { print } = await drawing(page);
      assert.ok(!prints.has(print), `${what} changes the drawing`);
      prints.add(print);
    };
    const layers = await page.locator('#colour-right option').evaluateAll((all) => all.map((o) => o.value));
    assert.deepEqual(layers, ['plain', 'region', 'truth', 'quality']);
    await page.selectOption('#colour-right', 'quality');
    await changed('quality');
    await page.selectOption('#colour-right', 'plain');
    await changed('plain');
    for (const key of ['sharp', 'feature', 'marks', 'edges', 'smooth']) {
      await page.locator(`#panel-layers [data-key=${key}]`).click();
      await changed(key);
    }
    for (const layout of ['split', 'single', 'side']) {
      await page.click(`.segmented [data-value=${layout}]`);
      if (layout === 'side') break;
      await changed(layout);
    }
    await page.click('.segmented [data-value=x]');
    await changed('a slice');
    assert.deepEqual(page.troubles, []);
    await page.close();
  });

  test('the view fits panes of any shape until it is moved', async () => {
    const page = await bench.page('quad.html', { viewport: { width: 1366, height: 500 } });
    /** How far the points reach towards the sides of their pane: 1 is the side itself. */
    const reach = () => page.evaluate(() => {
      const { stage } = window.carreau;
      const rect = stage.rect(0);
      let most = 0;
      stage.points((p) => {
        const q = p.clone().project(stage.orbit.place(rect.width / rect.height));
        most = Math.max(most, Math.abs(q.x), Math.abs(q.y));
      });
      return most;
    });
    const fits = async (what) => {
      // The browser tells of another shape when it likes to.
      let most = await reach();
      for (let k = 0; k < 100 && !(most > 0.8 && most < 0.95); k++) {
        await page.waitForTimeout(100);
        most = await reach();
      }
      assert.ok(most > 0.8 && most < 0.95, `${what}: ${most}`);
    };
    await fits('at first');
    await page.setViewportSize({ width: 800, height: 900 });
    await fits('narrow and high');
    await page.click('.segmented [data-value=single]');
    await fits('alone');
    const before = await page.evaluate(() => { window.carreau.stage.orbit.zoom(0.5); return window.carreau.stage.orbit.view(); });
    await page.setViewportSize({ width: 1366, height: 768 });
    await page.waitForTimeout(300);
    assert.equal(await page.evaluate(() => window.carreau.stage.orbit.view()), before);
    assert.deepEqual(page.troubles, []);
    await page.close();
  });

  test('the motorcycle graph is a layer of its own page and of its file', async () => {
    bench.run('motorcycle', 'bracket.ply', '-o', 'graph.vtp', '--report', 'motorcycle.html');
    bench.run('view', 'graph.vtp', '-o', 'graph.html');
    for (const [file, pane] of [['motorcycle.html', 1], ['graph.html', 0]]) {
      const page = await bench.page(file);
      const layer = page.locator('#panel-layers label', { has: page.locator('[data-key=track]') });
      assert.equal(await layer.innerText(), 'Motorcycle graph');
      assert.ok(await page.evaluate((k) => window.carreau.stage.panes[k].overlays.segmentsOf('track').length > 0, pane));
      const shown = await drawing(page);
      await page.keyboard.press('m');
      assert.notEqual((await drawing(page)).print, shown.print);
      await page.keyboard.press('m');
      assert.equal((await drawing(page)).print, shown.print);
      assert.deepEqual(page.troubles, []);
      await page.close();
    }
  });

  test('a click shows the numbers of the mesh', async () => {
    const { text, faces } = sheet();
    writeFileSync(bench.at('sheet.obj'), text);
    bench.run('view', 'sheet.obj', '-o', 'sheet.html');
    const page = await bench.page('sheet.html');
    await page.keyboard.press('z');
    const corner = (v) => [PLACE[0] + (v % (SIDE + 1)), PLACE[1] + Math.floor(v / (SIDE + 1)), PLACE[2]];
    for (const id of [0, 1, 40, 77, faces.length - 1]) {
      const middle = [0, 1, 2].map((k) => faces[id].reduce((sum, v) => sum + corner(v)[k], 0) / faces[id].length);
      const local = await page.evaluate((p) => {
        const { model } = window.carreau.stage.panes[0];
        return p.map((x, k) => (x - model.centre[k]) / model.scale);
      }, middle);
      await clickAt(page, 0, local);
      const shown = await card(page);
      assert.equal(shown.title, `Face ${id}: ${faces[id].length === 3 ? 'triangle' : 'quad'}`);
      assert.deepEqual(shown.corners, faces[id].map((v) => [v, corner(v)]));
      const quality = faces[id].length === 3 ? Math.sqrt(3) / 2 : 1;
      assert.ok(Math.abs(Number(shown.rows.quality) - quality) < 1e-6, shown.rows.quality);
      const at = shown.rows['clicked at'].split(', ').map(Number);
      assert.ok(at.every((x, k) => Math.abs(x - middle[k]) < 0.05), 'the clicked point is where the pointer was');
    }
    await page.keyboard.press('Escape');
    assert.equal((await card(page)).title, null);
    assert.deepEqual(page.troubles, []);
    await page.close();
  });

  test('slice, shrink and peel choose cells', async () => {
    bench.run('sample', 'tube-tree', '-o', 'tree.ply');
    bench.run('skeleton', 'tree.ply', '-o', 'tree.cgr');
    bench.run('hex', 'tree.cgr', '--refine-across', '1', '-o', 'tree.vtu', '--report', 'hex.html');
    const page = await bench.page('hex.html');
    const visible = () => page.evaluate(() => window.carreau.stage.panes[1].skin.visibleCount);
    const all = await page.evaluate(() => window.carreau.stage.panes[1].model.cells.count);
    assert.ok(all > 1000 && (await visible()) === all);
    const whole = await drawing(page);
    await page.click('.segmented [data-value=z]');
    const half = await visible();
    assert.ok(half > 0.1 * all && half < 0.9 * all, `${half} of ${all} cells`);
    assert.notEqual((await drawing(page)).print, whole.print);
    await page.locator('#panel-layers [data-key=flip]').click();
    const other = await visible();
    assert.ok(Math.abs(half + other - all) <= 0.02 * all, 'the two sides are the whole');
    await page.click('.segmented [data-value=off]');
    assert.equal((await drawing(page)).print, whole.print, 'and back');
    for (let k = 0; k < 3; k++) await page.keyboard.press(',');
    const shrunk = await drawing(page);
    assert.notEqual(shrunk.print, whole.print);
    // Only the worse half of the qualities.
    const count = await page.evaluate(() => {
      const app = window.carreau;
      const { stats, values } = app.shown()[1].quality;
      app.state.set({ keep: [-Infinity, stats.mean] });
      return values.filter((v) => v <= stats.mean).length;
    });
    assert.equal(await visible(), count);
    assert.deepEqual(page.troubles, []);
    await page.close();
  });

  test('the worst element is one click away', async () => {
    const page = await bench.page('quad.html', { hash: '#tab=quality' });
    assert.equal(await page.locator('.histogram:visible').count(), 2);
    const worst = await page.evaluate(() => {
      const { values } = window.carreau.shown()[1].quality;
      const least = values.reduce((best, v, k) => (v < values[best] ? k : best), 0);
      return { id: least, value: values[least] };
    });
    await page.locator('#panel-quality section').last().locator('.worst button').first().click();
    const shown = await card(page);
    assert.equal(shown.title, `Face ${worst.id}: quad`);
    assert.ok(Math.abs(Number(shown.rows.quality) - worst.value) < 1e-6);
    // A click on a bar shows its elements only.
    const before = await drawing(page);
    await page.locator('.histogram').last().click({ position: { x: 270, y: 50 } });
    assert.notEqual((await drawing(page)).print, before.print);
    assert.deepEqual(page.troubles, []);
    await page.close();
  });

  test('nodes of a skeleton tell their radius', async () => {
    const page = await bench.page('hex.html', { hash: '#layout=single' });
    const node = await page.evaluate(() => {
      const { model } = window.carreau.stage.panes[0];
      const [net] = model.nets;
      return { local: [...net.points.slice(0, 3)], radius: net.radii[0] * model.scale, id: net.ids[0] };
    });
    await clickAt(page, 0, node.local);
    const shown = await card(page);
    assert.equal(shown.title, `Node ${node.id}`);
    assert.ok(Math.abs(Number(shown.rows.radius) - node.radius) < 1e-6 * node.radius + 1e-12);
    await page.close();
  });

  test('the address says what is shown first, nonsense in it does no harm', async () => {
    const shown = (page) => page.evaluate(() => [window.carreau.state.layout, window.carreau.state.tab, window.carreau.theme.name, window.carreau.shown().map((m) => m.name)]);
    const asked = await bench.page('quad.html', { hash: '#layout=single&left=quads.obj&tab=run&theme=dark' });
    assert.deepEqual(await shown(asked), ['single', 'run', 'dark', ['quads.obj']]);
    const nonsense = await bench.page('quad.html', { hash: '#layout=7&left=none&tab=none&theme=none' });
    assert.deepEqual(await shown(nonsense), ['side', 'layers', 'light', ['bracket.ply', 'quads.obj']]);
    // Numbers of a model that is no longer shown go.
    await nonsense.keyboard.press('n');
    assert.notEqual((await card(nonsense)).title, null);
    await nonsense.selectOption('#scene-right', '0');
    assert.equal((await card(nonsense)).title, null);
    assert.deepEqual([...asked.troubles, ...nonsense.troubles], []);
    await Promise.all([asked.close(), nonsense.close()]);
  });

  test('keys do what the help says', async () => {
    const page = await bench.page('quad.html', { colorScheme: 'dark' });
    const layout = () => page.evaluate(() => window.carreau.state.layout);
    assert.equal(await page.evaluate(() => document.documentElement.dataset.theme), 'dark');
    const dark = await drawing(page);
    await page.keyboard.press('t');
    const light = await drawing(page);
    assert.ok(dark.background < 60 && light.background > 200);
    await page.keyboard.press('v');
    assert.equal(await layout(), 'split');
    await page.keyboard.press('?');
    assert.ok(await page.locator('#help').isVisible());
    await page.keyboard.press('Escape');
    assert.ok(await page.locator('#help').isHidden());
    const before = await drawing(page);
    await page.keyboard.press('ArrowLeft');
    assert.notEqual((await drawing(page)).print, before.print);
    await page.keyboard.press('n');
    assert.match((await card(page)).title, /^Face \d+: quad$/);
    // Every control has a name for those who do not see it.
    const nameless = await page.evaluate(() => Array.from(document.querySelectorAll('button, select, input, canvas'))
      .filter((e) => !(e.ariaLabel || e.textContent.trim() || e.labels?.[0]?.textContent.trim())).map((e) => e.outerHTML));
    assert.deepEqual(nameless, []);
    await page.close();
  });

  test('a name cannot become markup', async () => {
    const name = '<img src=x onerror=hacked=1>&<b>.obj';
    writeFileSync(bench.at(name), sheet().text);
    bench.run('view', name, '-o', 'name.html');
    const page = await bench.page('name.html');
    assert.equal(await page.title(), `carreau view ${name}`);
    assert.equal(await page.evaluate(() => window.hacked ?? document.querySelectorAll('img, b').length), 0);
    assert.deepEqual(page.troubles, []);
    await page.close();
  });

  test('half a million triangles load, turn and can be picked', async () => {
    bench.run('sample', 'noisy-torus', '--resolution', '520', '-o', 'large.ply');
    bench.run('view', 'large.ply', '-o', 'large.html');
    const page = await bench.page('large.html');
    assert.ok(await page.evaluate(() => window.carreau.shown()[0].faces.count) > 500_000);
    const before = await drawing(page);
    assert.ok(before.drawn > 0.05 && before.colors > 100);
    await page.keyboard.press('ArrowUp');
    assert.notEqual((await drawing(page)).print, before.print);
    const local = await page.evaluate(() => [...window.carreau.shown()[0].points.slice(0, 3)]);
    await clickAt(page, 0, local);
    assert.match((await card(page)).title, /^Face \d+: triangle$/);
    assert.deepEqual(page.troubles, []);
    await page.close();
  });
});
