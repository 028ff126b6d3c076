// A hand next to the moving target that invites to drag it, until the user does.

import { vec } from './arm.js';
import { element } from './notices.js';
import { state } from './state.js';

/** Distance of the hand from the target, px. */
const AWAY = 14;

let wasDragged = false;

/** Shows the hand at the target while the playground moves by itself. @type {(runControl: import('./run_control.js').RunControl, scene: import('./scene.js').Scene, world: import('./scene.js').World) => void} */
export function showInvite(runControl, { camera, canvas }, { goal, ghosts }) {
  const { setup, dragged, cursor } = runControl;
  wasDragged ||= dragged !== null || Object.keys(setup?.targets ?? {}).length > 0;
  const isShown = !wasDragged && goal !== null && cursor === null && ghosts.length === 0 && setup?.motion === 'eight' && state.value.phase === 'running';
  const hand = element('invite');
  if (hand.hidden === isShown) hand.hidden = !isShown;
  if (!isShown || !goal) return;
  const { x, y } = camera.project(vec(goal.pose.position));
  const left = Math.min(x + AWAY, canvas.clientWidth - hand.offsetWidth - 4);
  hand.style.translate = `${Math.round(left)}px ${Math.round(y + AWAY)}px`;
}
