// The service without a server: a worker with the WebAssembly module answers the requests of the page.

/**
 * @typedef {{id: number, status: number, body: string}} Answer
 * @typedef {{id: number, event?: string, done?: boolean}} LiveEvent
 */

/** A service in this browser. */
export class BrowserService {
  /** @param {Worker} worker */
  constructor(worker) {
    this.worker = worker;
    this.count = 0;
    /** Receivers of the messages by request. @type {Map<number, (message: any) => void>} */
    this.open = new Map();
    worker.onmessage = ({ data }) => this.open.get(data.id)?.(data);
    worker.onerror = () => {
      const detail = 'the service in this browser has stopped because of a defect; reload the page';
      const body = JSON.stringify({ type: '/problems/internal', title: 'A defect of the service', status: 500, detail });
      for (const receive of [...this.open.values()]) receive({ status: 500, body, done: true });
    };
  }

  /** @returns {Promise<BrowserService | null>} null if the folder of the page has no module */
  static async start() {
    const file = new URL('revprio.wasm', import.meta.url);
    const bytes = await fetch(file).then((response) => (response.ok ? response.arrayBuffer() : null), () => null);
    if (!bytes) return null;
    const module = await WebAssembly.compile(bytes);
    const worker = new Worker(new URL('browser_worker.js', import.meta.url), { type: 'module' });
    worker.postMessage({ module });
    return new BrowserService(worker);
  }

  /**
   * Answers like `fetch`.
   * @param {string} path
   * @param {RequestInit} init
   * @returns {Promise<Response>}
   */
  async fetch(path, { method = 'GET', body = null, signal = null }) {
    const id = ++this.count;
    if (path.endsWith('/live')) return new Response(this.events(id, path, signal ?? null));
    const answer = new Promise((/** @type {(answer: Answer) => void} */ resolve) => this.open.set(id, resolve));
    this.worker.postMessage({ id, method, path, body });
    const { status, body: text } = await answer;
    this.open.delete(id);
    const type = status < 400 ? 'application/json' : 'application/problem+json';
    return new Response(status === 204 ? null : text, { status, headers: { 'content-type': type } });
  }

  /**
   * @param {number} id
   * @param {string} path
   * @param {AbortSignal | null} signal
   * @returns {ReadableStream<Uint8Array>} server-sent events
   */
  events(id, path, signal) {
    const encoder = new TextEncoder();
    const close = () => {
      this.open.delete(id);
      this.worker.postMessage({ id, unfollow: true });
    };
    return new ReadableStream({
      start: (controller) => {
        signal?.addEventListener('abort', () => {
          close();
          controller.error(signal.reason);
        });
        this.open.set(id, (/** @type {LiveEvent} */ { event, done }) => {
          if (event) controller.enqueue(encoder.encode(event));
          if (!done) return;
          this.open.delete(id);
          controller.close();
        });
        this.worker.postMessage({ id, follow: path.replace(/live$/, 'advance') });
      },
      cancel: close,
    });
  }
}
