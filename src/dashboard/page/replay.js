// Plays the past of a run again, once or round and round.

import { element } from './notices.js';

/** @typedef {import('./run_control.js').RunControl} RunControl */

/** @type {{isPlaying: boolean, isLooping: boolean}} */
const replay = { isPlaying: false, isLooping: false };

/** @type {(runControl: RunControl) => void} */
export function bind(runControl) {
  element('replay').onclick = () => {
    replay.isPlaying = !replay.isPlaying;
    const { history } = runControl;
    if (replay.isPlaying && (runControl.cursor === null || runControl.cursor >= history.now)) runControl.cursor = history.first;
    runControl.onChange();
  };
  element('loop').onclick = () => {
    replay.isLooping = !replay.isLooping;
    runControl.onChange();
  };
  for (const id of ['time', 'live', 'go', 'reset', 'step']) element(id).addEventListener('pointerdown', () => { replay.isPlaying = false; });
}

/** Moves the shown time on. Returns whether it moves. @type {(runControl: RunControl, seconds: number) => boolean} */
export function advance(runControl, seconds) {
  const { history, cursor, setup } = runControl;
  // `Latest`, a new run or the end of the past stop the replay.
  if (replay.isPlaying && (cursor === null || history.length === 0)) replay.isPlaying = false;
  show(history.length > 0);
  if (!replay.isPlaying || cursor === null) return false;
  const next = cursor + seconds * (setup?.speed ?? 1);
  if (next < history.now) runControl.cursor = next;
  else if (replay.isLooping) runControl.cursor = history.first;
  else {
    runControl.cursor = null;
    replay.isPlaying = false;
  }
  return true;
}

/** @param {boolean} hasPast */
function show(hasPast) {
  const [play, loop] = /** @type {HTMLButtonElement[]} */ ([element('replay'), element('loop')]);
  const text = replay.isPlaying ? 'Stop' : 'Replay';
  if (play.textContent !== text) play.textContent = text;
  if (play.disabled === hasPast) play.disabled = !hasPast;
  const pressed = String(replay.isLooping);
  if (loop.ariaPressed !== pressed) loop.ariaPressed = pressed;
}
