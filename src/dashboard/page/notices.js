// Messages about errors with a remedy, and the dialog for the token.

import { state } from './state.js';
import { ApiError, storeToken, token } from './transport.js';

/** @type {<T extends HTMLElement>(id: string) => T} the element with this id; throws if there is none */
export function element(id) {
  const found = document.getElementById(id);
  if (!found) throw new Error(`the page has no #${id}`);
  return /** @type {any} */ (found);
}

/** Maximum number of messages at a time; the oldest goes first. */
const MAX_NOTICES = 4;

/** Time after which an `info` message disappears, ms. */
const INFO_TIME = 8000;

/**
 * Shows a message above the others. It replaces an earlier one about the same.
 * @param {string} title
 * @param {string} detail
 * @param {{info?: boolean, stays?: boolean, about?: string, act?: string, onAct?: () => void}} [options] `info`: no error;
 *   disappears by itself, unless it `stays`. `about`: what the message is about, by default its title
 */
export function notify(title, detail, { info = false, stays = !info, about = title, act, onAct } = {}) {
  const list = element('notice');
  const notice = made('div', info ? 'notice info' : 'notice');
  notice.role = 'alert';
  notice.dataset.about = about;
  const text = made('div');
  text.append(made('strong', '', title), made('p', '', detail));
  notice.append(text);
  const hide = () => notice.remove();
  if (act) notice.append(button(act, '', () => { hide(); onAct?.(); }));
  notice.append(Object.assign(button('✕', 'quiet', hide), { ariaLabel: `Close the message “${title}”` }));
  for (const old of /** @type {NodeListOf<HTMLElement>} */ (list.querySelectorAll('.notice'))) if (old.dataset.about === about) old.remove();
  list.prepend(notice);
  while (list.children.length > MAX_NOTICES) list.lastElementChild?.remove();
  if (!stays) setTimeout(hide, INFO_TIME);
}

/** @type {(kind: string, className?: string, text?: string) => HTMLElement} */
const made = (kind, className = '', text = '') => Object.assign(document.createElement(kind), { className, textContent: text });

/** @type {(text: string, className: string, onclick: () => void) => HTMLElement} */
const button = (text, className, onclick) => Object.assign(made('button', className, text), { type: 'button', onclick });

/**
 * Shows an error and what to do about it.
 * @param {unknown} error
 * @param {() => void} [retry] repeats the failed action
 */
export function showError(error, retry) {
  if (!(error instanceof ApiError)) {
    const detail = error instanceof Error ? error.message : String(error);
    notify('That did not work', detail, { about: detail });
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
    const given = field.value.trim();
    field.value = '';
    // A browser sends no other characters, such as the dash that a text editor made of two hyphens.
    if (!/^[!-~]+$/.test(given)) {
      const [title, detail] = given === ''
        ? ['This service needs a token', 'It answers nothing else without one.']
        : ['This is no token', 'It has a character that no token has. Copy it anew.'];
      notify(title, detail, { about: 'token', act: 'Give the token', onAct: () => askForToken(retry) });
      return;
    }
    storeToken(given);
    retry?.();
  };
}
