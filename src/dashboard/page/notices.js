// Messages about errors with a remedy, and the dialog for the token.

import { state } from './state.js';
import { ApiError, storeToken, token } from './transport.js';

/** @type {<T extends HTMLElement>(id: string) => T} the element with this id; throws if there is none */
export function element(id) {
  const found = document.getElementById(id);
  if (!found) throw new Error(`the page has no #${id}`);
  return /** @type {any} */ (found);
}

/** @type {number | undefined} */
let hideTimer;

/**
 * Shows a message; an `info` message disappears after 8 s.
 * @param {string} title
 * @param {string} detail
 * @param {{info?: boolean, act?: string, onAct?: () => void}} [options]
 */
export function notify(title, detail, { info = false, act, onAct } = {}) {
  clearTimeout(hideTimer);
  element('notice-title').textContent = title;
  element('notice-detail').textContent = detail;
  const button = element('notice-act');
  button.hidden = !act;
  button.textContent = act ?? '';
  button.onclick = () => {
    hideNotice();
    onAct?.();
  };
  element('notice').classList.toggle('info', info);
  element('notice').hidden = false;
  if (info) hideTimer = window.setTimeout(hideNotice, 8000);
}

export function hideNotice() {
  element('notice').hidden = true;
}

/**
 * Shows an error and what to do about it.
 * @param {unknown} error
 * @param {() => void} [retry] repeats the failed action
 */
export function showError(error, retry) {
  if (!(error instanceof ApiError)) {
    notify('That did not work', error instanceof Error ? error.message : String(error));
    return;
  }
  const { status, problem, retryAfter } = error;
  if (status === 0) {
    state.set({ connection: 'unreachable' });
  } else if (status === 401) {
    askForToken(retry);
  } else if (status === 503) {
    state.set({ connection: 'overloaded' });
    const wait = retryAfter ?? 1;
    const detail = `${capital(problem.detail)}. Wait ${wait} s before you try again.`;
    notify(problem.title, detail, { act: 'Try again', onAct: retry });
    setTimeout(() => state.value.connection === 'overloaded' && state.set({ connection: 'ready' }), 1000 * wait);
  } else {
    const at = problem.pointer ? ` (at ${problem.pointer})` : '';
    notify(problem.title, `${capital(problem.detail)}${at}.`);
  }
}

/** @type {(text: string) => string} */
const capital = (text) => text.charAt(0).toUpperCase() + text.slice(1);

/** @param {(() => void) | undefined} retry */
function askForToken(retry) {
  state.set({ connection: 'token_needed' });
  /** @type {HTMLDialogElement} */
  const dialog = element('token-dialog');
  /** @type {HTMLInputElement} */
  const field = element('token');
  element('token-wrong').hidden = token() === null;
  storeToken(null);
  field.value = '';
  if (!dialog.open) dialog.showModal();
  dialog.onclose = () => {
    if (field.value.trim() === '') return;
    storeToken(field.value.trim());
    field.value = '';
    retry?.();
  };
}
