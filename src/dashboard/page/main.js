// Connects the modules of the page and redraws it when something has changed.

import * as compare from './compare.js';
import * as controls from './controls.js';
import { RunControl } from './run_control.js';
import * as exporting from './export.js';
import * as editing from './editing.js';
import { drawFigures } from './figures.js';
import { drawLegends, drawSceneLegend } from './legends.js';
import { drawNumbers } from './numbers.js';
import { showInvite } from './invite.js';
import * as link from './link.js';
import { watchConnection } from './connection.js';
import { element, notify, showError } from './notices.js';
import * as pointer from './pointer.js';
import { roomController } from './room.js';
import * as replay from './replay.js';
import * as roomSwitch from './room_switch.js';
import { Scene } from './scene.js';
import { viewOf } from './shared_state.js';
import { state } from './state.js';
import * as swing from './swing.js';
import * as theme from './theme.js';
import * as timeline from './timeline.js';
import { ApiError } from './transport.js';
import { view } from './view.js';
import { world } from './world.js';

/** Minimum interval between two drawings of the scene on the canvas, and of the plots, ms: about 20 and 10 per second. */
const SCENE_INTERVAL = 45;
const PLOTS_INTERVAL = 95;

let needsRedraw = true;
let [sceneDrawn, plotsDrawn, replayed] = [0, 0, 0];

const scene = new Scene(element('scene'), element('solid'), element('free'));
const runControl = new RunControl(() => { needsRedraw = true; }, showError);

/** @type {(work: () => Promise<unknown>) => void} */
function attempt(work) {
  work().catch((error) => showError(error, () => attempt(work)));
}

editing.bind(runControl);
link.bind(runControl);
controls.bind(runControl, attempt);
timeline.bind(runControl);
pointer.bind(scene, runControl);
const recorder = exporting.bind(runControl, scene, attempt);
replay.bind(runControl);
scene.viewOfLink = viewOf(new URLSearchParams(location.hash.slice(1)).get('view'));

compare.bind(() => { needsRedraw = true; });
swing.bind(() => { needsRedraw = true; });
roomSwitch.bind(() => roomController(runControl), () => { needsRedraw = true; });
element('theme').onclick = () => theme.toggle();
theme.onTheme(() => { needsRedraw = true; });
element('close-up').onclick = () => {
  runControl.closeUp = !runControl.closeUp;
  element('close-up').ariaPressed = String(runControl.closeUp);
  needsRedraw = true;
};
const resized = new ResizeObserver(() => { needsRedraw = true; });
for (const id of ['scene', 'free', 'plots']) resized.observe(element(id));
addEventListener('scroll', () => { needsRedraw = true; }, { passive: true, capture: true });
addEventListener('pagehide', () => runControl.reset());
if (matchMedia('(max-width: 1180px)').matches) element('setup').removeAttribute('open');
if (matchMedia('(max-width: 1380px)').matches) element('plots').removeAttribute('open');

/** @param {number} now ms */
function draw(now) {
  requestAnimationFrame(draw);
  const isEven = scene.solid !== null;
  const isReplaying = replay.advance(runControl, Math.min(0.1, (now - replayed) / 1000));
  replayed = now;
  needsRedraw ||= isReplaying || swing.isSwinging() || scene.isMoving || (isEven && state.value.phase === 'running');
  if (!needsRedraw || (!isEven && now - sceneDrawn < SCENE_INTERVAL)) return;
  needsRedraw = false;
  sceneDrawn = now;
  const shown = world(runControl, isEven ? now / 1000 : null);
  const { scenario, watch } = runControl;
  const subject = watch?.session.id ?? `${scenario?.name} ${scenario?.controller.robot}`;
  scene.draw(shown, runControl.robot, subject, now);
  showInvite(runControl, scene, shown);
  compare.show(shown);
  recorder.addPicture();
  if (now - plotsDrawn < PLOTS_INTERVAL) {
    needsRedraw = true;
    return;
  }
  plotsDrawn = now;
  const data = view(runControl);
  controls.refresh(runControl);
  drawFigures(data);
  drawLegends(data);
  drawNumbers(runControl, data, shown.room);
  timeline.drawTimeline(runControl);
  drawSceneLegend(shown);
  roomSwitch.show(roomController(runControl), runControl.robot);
}
requestAnimationFrame(draw);

/** Loads scenarios and robots, and begins. A service that is too busy is asked again. */
async function begin() {
  try {
    await runControl.load();
  } catch (error) {
    if (!(error instanceof ApiError) || error.status !== 503) throw error;
    showError(error, () => attempt(begin));
    setTimeout(() => { if (runControl.scenario === null) attempt(begin); }, 1000 * (error.retryAfter ?? 1));
    return;
  }
  runControl.showSetup();
  state.set({ connection: 'ready' });
  if (!(await link.restore(runControl))) await runControl.startMotion();
}

watchConnection(async () => {
  if (state.value.connection !== 'unreachable') {
    await begin().catch((error) => showError(error, () => attempt(begin)));
    return;
  }
  try {
    await runControl.load();
    runControl.showSetup();
    state.set({ connection: 'ready' });
    const detail = state.value.phase === 'lost' ? 'The run was lost. Press Run to start a new one.' : 'No run was lost.';
    notify('The service is available again', detail, { info: true });
  } catch (error) {
    showError(error, () => attempt(begin));
  }
});
