// Whether the service can be reached, asked again and again.

import { state } from './state.js';
import { isAlive } from './transport.js';

/** Between two looks while all is well, and while it is not, ms. */
const CALM = 2000;
const ANXIOUS = 700;

/**
 * Looks for ever; `onBack` hears when the service can be reached again, the first time included.
 * @param {() => Promise<void>} onBack
 */
export async function watchLink(onBack) {
  for (;;) {
    const alive = await isAlive();
    const { link } = state.value;
    if (!alive) state.set({ link: link === 'connecting' ? 'connecting' : 'gone' });
    if (alive && (link === 'gone' || link === 'connecting')) await onBack();
    await new Promise((resolve) => setTimeout(resolve, alive ? CALM : ANXIOUS));
  }
}
