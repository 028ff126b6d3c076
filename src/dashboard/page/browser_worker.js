// The worker of `browser_service.js`: it holds the WebAssembly module, and advances the runs that the page follows.

/**
 * @typedef {{memory: WebAssembly.Memory, request_buffer: (length: number) => number, call: () => number, answer_buffer: () => number}} Exports
 * @typedef {{status: number, body: any}} Answer
 */

/** Time between two looks at a run, ms. */
const ADVANCE_INTERVAL = 15;

/** @type {Promise<Exports>} */
let service;

/** Timers of the followed runs, by request. @type {Map<number, number>} */
const followed = new Map();

onmessage = async ({ data }) => {
  if (data.module) {
    const host = { now_ms: () => performance.now() };
    const module = /** @type {WebAssembly.Module} */ (data.module);
    service = WebAssembly.instantiate(module, { host }).then(({ exports }) => /** @type {any} */ (exports));
    return;
  }
  const { id, method, path, body, follow, unfollow } = data;
  if (unfollow) stop(id);
  else if (follow) advance(id, follow);
  else {
    const { status, body: answer } = await call(method, path, body);
    postMessage({ id, status, body: JSON.stringify(answer) });
  }
};

/**
 * @param {string} method
 * @param {string} path
 * @param {string | null} body JSON
 * @returns {Promise<Answer>}
 */
async function call(method, path, body) {
  const head = JSON.stringify({ method, path }).slice(0, -1);
  const request = new TextEncoder().encode(body ? `${head},"body":${body}}` : `${head}}`);
  try {
    const { memory, request_buffer: room, call: answer, answer_buffer: place } = await service;
    // Each call may move the memory to a new buffer.
    const start = room(request.length);
    new Uint8Array(memory.buffer, start, request.length).set(request);
    const length = answer();
    return JSON.parse(new TextDecoder().decode(new Uint8Array(memory.buffer, place(), length)));
  } catch (error) {
    const detail = `the service in this browser has stopped because of a defect; reload the page (${error})`;
    return { status: 500, body: { type: '/problems/internal', title: 'A defect of the service', status: 500, detail } };
  }
}

/** Advances a run and sends its new frame, again and again until it ends. @type {(id: number, path: string) => Promise<void>} */
async function advance(id, path) {
  followed.set(id, setTimeout(() => advance(id, path), ADVANCE_INTERVAL));
  const { status, body } = await call('POST', path, null);
  if (!followed.has(id)) return;
  const done = status !== 200 || body.name === 'end';
  const event = body.frame ? `event: ${body.name}\ndata: ${JSON.stringify(body.frame)}\n\n` : undefined;
  if (event || done) postMessage({ id, event, done });
  if (done) stop(id);
}

/** @param {number} id */
function stop(id) {
  clearTimeout(followed.get(id));
  followed.delete(id);
}
