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

/** Replaces the children of an element; the one that had the focus gives it to its successor. */
export function clear(element, ...children) {
  const focused = element.contains(document.activeElement) && nameOf(document.activeElement);
  element.replaceChildren(...children.flat(3).filter((c) => c != null && c !== false));
  if (focused) element.querySelector(focused)?.focus({ preventScroll: true });
}

/** A selector that finds a control again after its panel was rebuilt. */
function nameOf({ id, dataset, parentElement }) {
  if (id) return `#${CSS.escape(id)}`;
  if (dataset.key) return `[data-key="${dataset.key}"]`;
  return dataset.value && `[aria-label="${parentElement.ariaLabel}"] [data-value="${dataset.value}"]`;
}

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
