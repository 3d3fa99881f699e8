// Small helpers to make elements. Text is set as text, never as HTML.

/** An element with attributes, listeners (`onclick` …) and children. */
export function h(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith('on')) element.addEventListener(name.slice(2), value);
    else if (value === true) element.setAttribute(name, '');
    else if (value !== false && value != null) element.setAttribute(name, value);
  }
  element.append(...children.flat(3).filter((c) => c != null && c !== false));
  return element;
}

export const clear = (element, ...children) => element.replaceChildren(...children.flat(3).filter((c) => c != null && c !== false));

export function select(label, options, value, onchange, id) {
  const box = h('select', { id, 'aria-label': label, onchange: () => onchange(box.value) },
    options.map(([key, text]) => h('option', { value: key, selected: String(key) === String(value) }, text)));
  return box;
}

export function checkbox(label, checked, onchange, extra = {}) {
  const box = h('input', { type: 'checkbox', checked, onchange: () => onchange(box.checked), ...extra });
  return h('label', { class: 'check' }, box, h('span', {}, label));
}

export function slider(label, { min, max, step, value, text = String }, oninput, extra = {}) {
  const shown = h('output', {}, text(value));
  const box = h('input', {
    type: 'range', min, max, step, value, 'aria-label': label, ...extra,
    oninput: () => {
      shown.textContent = text(Number(box.value));
      oninput(Number(box.value));
    },
  });
  return h('label', { class: 'slider' }, h('span', {}, label), box, shown);
}

/** A group of choices of which one is pressed. */
export function segmented(label, options, value, onchange) {
  return h('div', { class: 'segmented', role: 'group', 'aria-label': label },
    options.map(([key, text, title]) => h('button', {
      type: 'button', title, 'data-value': key, 'aria-pressed': String(key === value), onclick: () => onchange(key),
    }, text)));
}
