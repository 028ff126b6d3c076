// The time that the page shows: the slider, and the pointer and the keyboard in the plots.

import { cards, hoveredLines, readings, setPointer, timeAt } from './figures.js';
import { element } from './notices.js';
import { fixed } from './number.js';

/** @typedef {import('./run_control.js').RunControl} RunControl */

/** Part of the shown time by which an arrow key moves the cursor. */
const KEY_STEP = 1 / 200;

/** @param {RunControl} runControl */
export function bind(runControl) {
  /** @type {HTMLInputElement} */
  const slider = element('time');
  slider.oninput = () => show(runControl, Number(slider.value));
  element('live').onclick = () => show(runControl, null);
  for (const card of cards()) bindPlot(runControl, card);
}

/** Shows a time; null shows the latest. @type {(runControl: RunControl, time: number | null) => void} */
function show(runControl, time) {
  const { history } = runControl;
  runControl.cursor = time === null || history.length === 0 || time >= history.now ? null : Math.max(history.first, time);
  runControl.onChange();
}

/** @type {(runControl: RunControl, card: HTMLElement) => void} */
function bindPlot(runControl, card) {
  const canvas = /** @type {HTMLCanvasElement} */ (card.querySelector('canvas'));
  const plot = card.dataset.plot ?? '';
  let isHeld = false;
  const follow = (/** @type {PointerEvent} */ event) => {
    const frame = readings.get(plot)?.frame;
    const time = frame ? timeAt(frame, event.offsetX) : null;
    if (isHeld && time !== null) show(runControl, time);
    setPointer({ plot, x: event.offsetX, y: event.offsetY });
    showTip(event.clientX, event.clientY);
    runControl.onChange();
  };
  canvas.onpointermove = follow;
  canvas.onpointerdown = (event) => {
    if (event.pointerType === 'mouse' && event.button !== 0) return;
    if (event.pointerType === 'mouse') canvas.setPointerCapture(event.pointerId);
    isHeld = true;
    follow(event);
  };
  const release = () => { isHeld = false; };
  canvas.onpointerup = release;
  canvas.onpointercancel = release;
  canvas.onpointerleave = () => {
    setPointer(null);
    element('tip').hidden = true;
    runControl.onChange();
  };
  canvas.onkeydown = (event) => moveWithKeys(runControl, plot, event);
}

/** @type {(runControl: RunControl, plot: string, event: KeyboardEvent) => void} */
function moveWithKeys(runControl, plot, event) {
  const frame = readings.get(plot)?.frame;
  const { history, cursor } = runControl;
  if (!frame || history.length === 0) return;
  const range = frame.x.high - frame.x.low;
  const now = cursor ?? history.now;
  /** @type {Record<string, number | null>} */
  const places = {
    ArrowLeft: now - range * KEY_STEP, ArrowRight: now + range * KEY_STEP, PageDown: now - range / 10, PageUp: now + range / 10,
    Home: history.first, End: null,
  };
  if (!(event.key in places)) return;
  event.preventDefault();
  show(runControl, places[event.key]);
  const reading = readings.get(plot);
  element('reading').textContent = (reading?.at(runControl.cursor ?? history.now, 0) ?? []).join(', ');
}

/** Shows the lines under the pointer. @type {(x: number, y: number) => void} */
function showTip(x, y) {
  const tip = element('tip');
  const lines = hoveredLines();
  tip.hidden = lines.length === 0;
  if (tip.hidden) return;
  tip.replaceChildren(...lines.map((text) => {
    const line = document.createElement('div');
    line.textContent = text;
    return line;
  }));
  const { width, height } = tip.getBoundingClientRect();
  tip.style.left = `${Math.max(4, Math.min(x + 14, innerWidth - width - 4))}px`;
  tip.style.top = `${y - height - 10 < 4 ? y + 16 : y - height - 10}px`;
}

/** Updates the slider. @type {(runControl: RunControl) => void} */
export function drawTimeline({ history, cursor }) {
  /** @type {HTMLInputElement} */
  const slider = element('time');
  const now = history.now;
  slider.min = String(history.first);
  slider.max = String(Math.max(now, history.first + 1e-3));
  slider.value = String(cursor ?? now);
  slider.disabled = history.length === 0;
  slider.ariaValueText = `${fixed(cursor ?? now, 3)} s${cursor === null ? ', latest' : ''}`;
  element('live').hidden = cursor === null;
  element('viewing').hidden = cursor === null;
}
