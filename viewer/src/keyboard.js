// Keys; see help.js for the list.

const TURN = 0.12;

export function listenToKeys(app) {
  const { state, stage } = app;
  const cycle = (name, values) => state.set({ [name]: values[(values.indexOf(state[name]) + 1) % values.length] });
  const colours = (step) => {
    const model = app.shown().at(-1);
    if (!model) return;
    const names = ['plain', ...model.layers.filter((l) => l.kind !== 'vector').map((l) => l.name)];
    const now = names.indexOf(app.colourOf(model)?.name ?? 'plain');
    app.colourBy(model, names[(now + step + names.length) % names.length]);
  };
  const colourAt = (k) => {
    const model = app.shown().at(-1);
    const names = ['plain', ...(model?.layers.filter((l) => l.kind !== 'vector').map((l) => l.name) ?? [])];
    if (names[k]) app.colourBy(model, names[k]);
  };
  const look = (axis, back) => {
    const eye = [0, 0, 0];
    eye['xyz'.indexOf(axis)] = back ? -1 : 1;
    stage.orbit.lookFrom(eye, axis === 'z' ? [0, 1, 0] : [0, 0, 1]);
    stage.fit();
  };
  const move = (step) => state.axis !== 'off' && state.set({ at: Math.min(1, Math.max(0, state.at + step)) });
  const size = (step) => state.set({ shrink: Math.min(1, Math.max(0.2, state.shrink + step)) });
  const keys = {
    ArrowLeft: () => stage.orbit.rotate(-TURN, 0), ArrowRight: () => stage.orbit.rotate(TURN, 0),
    ArrowUp: () => stage.orbit.rotate(0, -TURN), ArrowDown: () => stage.orbit.rotate(0, TURN),
    '+': () => stage.orbit.zoom(0.85), '=': () => stage.orbit.zoom(0.85), '-': () => stage.orbit.zoom(1 / 0.85),
    f: () => app.goHome(), v: () => app.head.scenes.length > 1 && cycle('layout', ['single', 'side', 'split']),
    x: () => look('x'), X: () => look('x', true), y: () => look('y'), Y: () => look('y', true), z: () => look('z'), Z: () => look('z', true),
    c: () => colours(1), C: () => colours(-1),
    e: () => state.set({ edges: !state.edges }), s: () => app.toggle('sharp'), b: () => app.toggle('region'), k: () => app.toggle('skeleton'), m: () => app.toggle('track'),
    l: () => cycle('axis', ['off', 'x', 'y', 'z']), '[': () => move(-0.02), ']': () => move(0.02),
    ',': () => size(-0.1), '.': () => size(0.1),
    n: () => app.quality.next(1), p: () => app.quality.next(-1),
    t: () => state.set({ theme: app.theme.name === 'dark' ? 'light' : 'dark' }), h: () => state.set({ sidebar: !state.sidebar }),
    Escape: () => state.set({ picked: null }), '?': () => app.help.toggle(),
  };
  for (let k = 1; k <= 9; k++) keys[k] = () => colourAt(k - 1);
  document.addEventListener('keydown', (e) => {
    if (e.ctrlKey || e.metaKey || e.altKey || e.defaultPrevented) return;
    // Sliders and lists use keys of their own.
    const own = e.target.closest?.('select, input[type=range], dialog[open]');
    if (own && (e.key.startsWith('Arrow') || own.tagName === 'SELECT' || (own.tagName === 'DIALOG' && e.key !== '?'))) return;
    const action = keys[e.key];
    if (!action) return;
    action();
    e.preventDefault();
  });
}
