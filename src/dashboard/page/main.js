// Puts the page together and draws it when there is something new.

import * as controls from './controls.js';
import { Desk } from './desk.js';
import * as exporting from './exporting.js';
import { drawFigures, drawLegends, drawNumbers, drawSceneLegend } from './figures.js';
import { watchLink } from './link.js';
import { element, explain, hideNotice, notify } from './notices.js';
import * as pointer from './pointer.js';
import { Scene } from './scene.js';
import { state } from './state.js';
import * as theme from './theme.js';

/** Between two pictures of the scene and of the plots, ms: some twenty and ten a second. */
const SCENE_PAUSE = 45;
const PLOTS_PAUSE = 95;

let isNew = true;
let [sceneDrawn, plotsDrawn] = [0, 0];

const scene = new Scene(element('scene'));
const desk = new Desk(() => { isNew = true; }, explain);

/** @type {(work: () => Promise<unknown>) => void} */
function attempt(work) {
  work().catch((error) => explain(error, () => attempt(work)));
}

controls.bind(desk, attempt);
pointer.bind(scene, desk);
exporting.bind(desk, scene, attempt);

element('theme').onclick = () => theme.toggle();
theme.onTheme(() => { isNew = true; });
element('notice-close').onclick = hideNotice;
element('close-up').onclick = () => {
  desk.closeUp = !desk.closeUp;
  element('close-up').ariaPressed = String(desk.closeUp);
  isNew = true;
};
new ResizeObserver(() => { isNew = true; }).observe(element('scene'));
addEventListener('scroll', () => { isNew = true; }, { passive: true });
addEventListener('pagehide', () => desk.reset());
if (matchMedia('(max-width: 760px)').matches) element('setup').removeAttribute('open');

/** @param {number} now ms */
function draw(now) {
  requestAnimationFrame(draw);
  if (!isNew || now - sceneDrawn < SCENE_PAUSE) return;
  isNew = false;
  sceneDrawn = now;
  const { arm } = desk;
  const world = desk.world();
  if (arm) scene.fit(arm, world.contacts, desk.watch?.session.id ?? desk.scenario?.name ?? '');
  scene.draw(world);
  if (now - plotsDrawn < PLOTS_PAUSE) {
    isNew = true;
    return;
  }
  plotsDrawn = now;
  const view = desk.view();
  drawFigures(view);
  drawLegends(view);
  drawNumbers(desk, view);
  drawSceneLegend(desk);
}
requestAnimationFrame(draw);

watchLink(async () => {
  const wasGone = state.value.link === 'gone';
  try {
    await desk.load();
    desk.showSetup();
    state.set({ link: 'ready' });
    if (!wasGone) return;
    if (state.value.phase === 'lost') notify('The service is back', 'The run ended with it; Run starts a new one.', { calm: true });
    else notify('The service is back', 'Everything works as before.', { calm: true });
  } catch (error) {
    explain(error, () => attempt(async () => {
      await desk.load();
      desk.showSetup();
      state.set({ link: 'ready' });
    }));
  }
});
