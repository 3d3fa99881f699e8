// What is shown, and who wants to know when it changes.

export class State {
  constructor(values) {
    this.values = values;
    this.listeners = [];
    for (const name of Object.keys(values)) Object.defineProperty(this, name, { get: () => this.values[name] });
  }

  /** Changes values; listeners are told which. */
  set(changes) {
    const changed = new Set(Object.keys(changes).filter((name) => this.values[name] !== changes[name]));
    Object.assign(this.values, changes);
    if (changed.size > 0) this.listeners.forEach((listener) => listener(changed));
  }

  listen(listener) {
    this.listeners.push(listener);
  }
}
