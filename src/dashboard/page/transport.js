// Requests to the service: JSON bodies, server-sent events, problem reports and the token.

import { BrowserService } from './browser_service.js';

/** @typedef {Pick<import('./types.js').Problem, 'title' | 'status' | 'detail' | 'pointer' | 'candidates'>} Problem */

const TOKEN = 'revprio-token';

/** Address in copied commands if the page has no server: the default of `revprio serve`. */
const DEFAULT_ADDRESS = 'http://127.0.0.1:8080';

/** The service in this browser; null: a server. @type {BrowserService | null} */
let inBrowser = null;

/** Whether a server has answered. The page then stays with it. */
let hasServer = false;

/** An error of a request: the service refused it, or there was no answer (status 0). */
export class ApiError extends Error {
  /**
   * @param {number} status
   * @param {Problem} problem
   * @param {number} [retryAfter] seconds
   */
  constructor(status, problem, retryAfter) {
    super(problem.detail);
    this.status = status;
    this.problem = problem;
    this.retryAfter = retryAfter;
  }
}

/** @returns {string | null} the token that is stored in this browser tab */
export function token() {
  return sessionStorage.getItem(TOKEN);
}

/** @param {string | null} value stored in this browser tab until it is closed */
export function storeToken(value) {
  if (value) sessionStorage.setItem(TOKEN, value);
  else sessionStorage.removeItem(TOKEN);
}

/** @returns {Record<string, string>} */
function credentials() {
  const secret = token();
  return secret ? { authorization: `Bearer ${secret}` } : {};
}

/**
 * @param {string} path
 * @param {RequestInit} [init]
 * @returns {Promise<Response>} a successful answer; otherwise throws an `ApiError`
 */
async function send(path, init = {}) {
  let response;
  try {
    response = inBrowser
      ? await inBrowser.fetch(path, init)
      : await fetch(path, { ...init, headers: { ...init.headers, ...credentials() }, cache: 'no-store' });
  } catch (error) {
    if (init.signal?.aborted) throw error;
    const detail = 'the service does not answer; is it still running?';
    throw new ApiError(0, { title: 'No answer', status: 0, detail });
  }
  if (response.ok) return response;
  throw new ApiError(response.status, await problemOf(response), Number(response.headers.get('retry-after')) || undefined);
}

/**
 * @param {Response} response
 * @returns {Promise<Problem>}
 */
async function problemOf(response) {
  const isProblem = response.headers.get('content-type')?.startsWith('application/problem+json');
  if (isProblem) return response.json();
  const detail = `the answer with status ${response.status} is not from a revprio service`;
  return { title: 'Unexpected answer', status: response.status, detail };
}

/**
 * @template T
 * @param {string} path
 * @returns {Promise<T>}
 */
export async function get(path) {
  return (await send(path)).json();
}

/**
 * @template T
 * @param {string} path
 * @param {unknown} body
 * @returns {Promise<T>}
 */
export async function post(path, body) {
  const headers = { 'content-type': 'application/json' };
  return (await send(path, { method: 'POST', headers, body: JSON.stringify(body) })).json();
}

/**
 * Sends a DELETE request, which continues when the page is closed.
 * @param {string} path
 */
export async function remove(path) {
  await send(path, { method: 'DELETE', keepalive: true });
}

/** Sends a DELETE request and waits for its answer. @param {string} path */
export async function removeNow(path) {
  await send(path, { method: 'DELETE' });
}

/**
 * @param {string} path
 * @param {string} type accepted media type
 * @returns {Promise<Blob>}
 */
export async function download(path, type) {
  return (await send(path, { headers: { accept: type } })).blob();
}

/** Returns whether the service is reachable; needs no token. Without a server the page starts the service in this browser. */
export async function isAlive() {
  if (inBrowser) return true;
  const isServer = await serverAnswers();
  hasServer ||= isServer;
  if (!hasServer) inBrowser = await BrowserService.start();
  return isServer || inBrowser !== null;
}

/** Whether the last check got no answer in time. */
let wasMissed = false;

/** Returns whether a server answers. A single late answer is forgiven: a busy machine gives such ones. */
async function serverAnswers() {
  try {
    const response = await fetch('/healthz', { cache: 'no-store', signal: AbortSignal.timeout(2000) });
    wasMissed = false;
    return response.ok && (await response.text()) === 'ok';
  } catch (error) {
    const isLate = error instanceof DOMException && error.name === 'TimeoutError';
    const isForgiven = hasServer && !wasMissed && isLate;
    wasMissed = true;
    return isForgiven;
  }
}

/** Returns whether the service runs in this browser. */
export function isInBrowser() {
  return inBrowser !== null;
}

/** Returns the address of the service in copied commands. */
export function address() {
  return inBrowser ? DEFAULT_ADDRESS : location.origin;
}

/**
 * Reads server-sent events until the stream ends. An EventSource cannot send the token.
 * @param {string} path
 * @param {(name: string, data: any) => void} onEvent
 * @param {AbortSignal} signal
 */
export async function events(path, onEvent, signal) {
  const response = await send(path, { headers: { accept: 'text/event-stream' }, signal });
  if (!response.body) return;
  const reader = response.body.pipeThrough(new TextDecoderStream()).getReader();
  let text = '';
  for (;;) {
    const { value, done } = await reader.read();
    if (done) return;
    text += value;
    const blocks = text.split('\n\n');
    text = blocks.pop() ?? '';
    for (const block of blocks) dispatch(block, onEvent);
  }
}

/**
 * @param {string} block the lines of one event
 * @param {(name: string, data: any) => void} onEvent
 */
function dispatch(block, onEvent) {
  let name = 'message';
  let data = '';
  for (const line of block.split('\n')) {
    if (line.startsWith('event: ')) name = line.slice(7);
    if (line.startsWith('data: ')) data += line.slice(6);
  }
  if (data) onEvent(name, JSON.parse(data));
}
