// The choice of the data source: a simulation, or a session of another client.

import { element } from './notices.js';
import { state } from './state.js';
import { sessions } from './watch.js';

/**
 * @typedef {import('./run_control.js').RunControl} RunControl
 * @typedef {import('./controls.js').Attempt} Attempt
 */

/** @type {(id: string) => HTMLSelectElement} */
const select = (id) => element(id);

/** @type {(runControl: RunControl, attempt: Attempt) => void} */
export function bind(runControl, attempt) {
  for (const choice of /** @type {NodeListOf<HTMLInputElement>} */ (document.querySelectorAll('input[name="source"]'))) {
    choice.onchange = () => {
      const source = choice.value === 'session' ? 'session' : 'simulation';
      state.set({ source });
      if (source === 'session') {
        runControl.reset();
        attempt(() => listSessions(runControl, attempt));
      } else {
        attempt(() => runControl.leaveSession());
      }
    };
  }
  select('session').onchange = () => attempt(() => runControl.watchSession(select('session').value));
  setInterval(() => {
    const { source, connection } = state.value;
    const refreshes = source === 'session' && connection === 'ready' && document.activeElement !== select('session');
    if (refreshes) attempt(() => listSessions(runControl, attempt));
  }, 3000);
}

/** @type {(runControl: RunControl, attempt: Attempt) => Promise<void>} */
async function listSessions(runControl, attempt) {
  const { controllers } = await sessions();
  const { session, source } = state.value;
  // The user has left the sessions meanwhile.
  if (source !== 'session') return;
  const known = controllers.map(({ id, robot, steps, idle_s }) => ({
    value: id, name: `${robot}, ${id.slice(0, 8)}: ${steps} steps, ${idle_s < 2 ? 'active' : `idle ${Math.round(idle_s)} s`}`,
  }));
  const none = { value: '', name: known.length > 0 ? 'select a session' : 'no session is open' };
  select('session').replaceChildren(...[none, ...known].map(({ value, name }) => new Option(name, value)));
  const chosen = session === '' && known.length === 1 ? known[0].value : session;
  select('session').value = controllers.some(({ id }) => id === chosen) ? chosen : '';
  if (chosen !== session) attempt(() => runControl.watchSession(chosen));
}

