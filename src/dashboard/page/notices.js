// What went wrong, with what to do; the question for the token.

import { state } from './state.js';
import { ApiError, keepToken, token } from './transport.js';

/** @type {<T extends HTMLElement>(id: string) => T} an element that the page has */
export function element(id) {
  const found = document.getElementById(id);
  if (!found) throw new Error(`the page has no #${id}`);
  return /** @type {any} */ (found);
}

/** @type {number | undefined} */
let fading;

/**
 * @param {string} title
 * @param {string} detail
 * @param {{calm?: boolean, act?: string, onAct?: () => void}} [options]
 */
export function notify(title, detail, { calm = false, act, onAct } = {}) {
  clearTimeout(fading);
  element('notice-title').textContent = title;
  element('notice-detail').textContent = detail;
  const button = element('notice-act');
  button.hidden = !act;
  button.textContent = act ?? '';
  button.onclick = () => {
    hideNotice();
    onAct?.();
  };
  element('notice').classList.toggle('calm', calm);
  element('notice').hidden = false;
  if (calm) fading = window.setTimeout(hideNotice, 8000);
}

export function hideNotice() {
  element('notice').hidden = true;
}

/**
 * Says what a failure means and what would help.
 * @param {unknown} error
 * @param {() => void} [again] tries once more what failed
 */
export function explain(error, again) {
  if (!(error instanceof ApiError)) {
    notify('The run did not go on', error instanceof Error ? error.message : String(error));
    return;
  }
  const { status, problem, retryAfter } = error;
  if (status === 0) {
    state.set({ link: 'gone' });
  } else if (status === 401) {
    askForToken(again);
  } else if (status === 503) {
    state.set({ link: 'overloaded' });
    const wait = retryAfter ?? 1;
    notify(problem.title, `${capital(problem.detail)}. The service asks to wait ${wait} s.`, { act: 'Try again', onAct: again });
    setTimeout(() => state.value.link === 'overloaded' && state.set({ link: 'ready' }), 1000 * wait);
  } else {
    const at = problem.pointer ? ` (at ${problem.pointer})` : '';
    notify(problem.title, `${capital(problem.detail)}${at}.`);
  }
}

/** @type {(text: string) => string} */
const capital = (text) => text.charAt(0).toUpperCase() + text.slice(1);

/** @param {(() => void) | undefined} again */
function askForToken(again) {
  state.set({ link: 'locked' });
  /** @type {HTMLDialogElement} */
  const dialog = element('token-dialog');
  /** @type {HTMLInputElement} */
  const field = element('token');
  element('token-wrong').hidden = token() === null;
  keepToken(null);
  field.value = '';
  if (!dialog.open) dialog.showModal();
  dialog.onclose = () => {
    if (field.value.trim() === '') return;
    keepToken(field.value.trim());
    field.value = '';
    again?.();
  };
}
