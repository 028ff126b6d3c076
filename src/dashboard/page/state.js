// What the page knows, and who hears of changes.

/**
 * @typedef {'connecting' | 'ready' | 'overloaded' | 'gone' | 'locked'} Link whether the service can be talked to
 * @typedef {'none' | 'starting' | 'running' | 'paused' | 'finished' | 'failed' | 'cancelled' | 'lost' | 'watching'} Phase
 *
 * @typedef {object} State
 * @property {Link} link
 * @property {Phase} phase
 * @property {'simulation' | 'session'} source
 * @property {string} session session that is watched
 * @property {boolean} pending whether the set-up differs from that of the run in what only a new run takes over
 */

/**
 * A value whose changes others hear of.
 * @template {object} T
 */
export class Store {
  /** @param {T} initial */
  constructor(initial) {
    /** @type {T} */
    this.value = initial;
    /** @type {Set<(now: T, before: T) => void>} */
    this.listeners = new Set();
  }

  /** @param {Partial<T>} change */
  set(change) {
    const before = this.value;
    const keys = /** @type {(keyof T)[]} */ (Object.keys(change));
    if (keys.every((key) => before[key] === change[key])) return;
    this.value = { ...before, ...change };
    for (const listener of this.listeners) listener(this.value, before);
  }

  /** @param {(now: T, before: T) => void} listener hears of the present value too */
  subscribe(listener) {
    this.listeners.add(listener);
    listener(this.value, this.value);
  }
}

/** @type {State} */
const initial = { link: 'connecting', phase: 'none', source: 'simulation', session: '', pending: false };

export const state = new Store(initial);
