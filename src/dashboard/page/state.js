// The state of the page, with notification of changes.

/**
 * @typedef {'connecting' | 'ready' | 'overloaded' | 'unreachable' | 'token_needed'} Connection
 * @typedef {'none' | 'starting' | 'running' | 'paused' | 'finished' | 'failed' | 'cancelled' | 'lost' | 'watching'} Phase
 *
 * @typedef {object} State
 * @property {Connection} connection
 * @property {Phase} phase
 * @property {'simulation' | 'session'} source
 * @property {string} session id of the watched session
 * @property {boolean} pending whether the setup has changes that need a new run
 */

/**
 * A value that notifies listeners of changes.
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

  /** @param {(now: T, before: T) => void} listener called now and after each change */
  subscribe(listener) {
    this.listeners.add(listener);
    listener(this.value, this.value);
  }
}

/** @type {State} */
const initial = { connection: 'connecting', phase: 'none', source: 'simulation', session: '', pending: false };

export const state = new Store(initial);
