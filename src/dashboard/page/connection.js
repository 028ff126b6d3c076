// Checks periodically whether the service can be reached.

import { state } from './state.js';
import { isAlive } from './transport.js';

/** Interval between two checks while the service is reachable, and while it is not, ms. */
const CHECK_INTERVAL = 2000;
const RETRY_INTERVAL = 700;

/**
 * Checks until the page is closed.
 * @param {() => Promise<void>} onReachable called when the service becomes reachable, including the first time
 */
export async function watchConnection(onReachable) {
  for (;;) {
    const alive = await isAlive();
    const { connection } = state.value;
    if (!alive) state.set({ connection: connection === 'connecting' ? 'connecting' : 'unreachable' });
    if (alive && (connection === 'unreachable' || connection === 'connecting')) await onReachable();
    await new Promise((resolve) => setTimeout(resolve, alive ? CHECK_INTERVAL : RETRY_INTERVAL));
  }
}
