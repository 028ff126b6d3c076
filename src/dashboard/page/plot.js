// Axes, curves and other parts of plots. They draw on any object with the methods of a canvas context.

/**
 * @typedef {import('./theme.js').Palette} Palette
 * @typedef {CanvasRenderingContext2D} Surface
 *
 * @typedef {object} Range
 * @property {number} low
 * @property {number} high
 * @property {boolean} [log] whether the scale is logarithmic
 *
 * @typedef {object} Frame the area of a plot, px, with its axes
 * @property {number} left
 * @property {number} top
 * @property {number} width
 * @property {number} height
 * @property {Range} x
 * @property {Range} y
 */

export const FONT = '11px system-ui, -apple-system, "Segoe UI", sans-serif';

/** @type {(range: Range, value: number) => number} position of the value in the range, 0 to 1 */
function fraction(range, value) {
  if (!range.log) return (value - range.low) / (range.high - range.low);
  return Math.log(Math.max(value, 1e-300) / range.low) / Math.log(range.high / range.low);
}

/** @type {(frame: Frame, value: number) => number} */
export const atX = (frame, value) => frame.left + frame.width * fraction(frame.x, value);
/** @type {(frame: Frame, value: number) => number} */
export const atY = (frame, value) => frame.top + frame.height * (1 - fraction(frame.y, value));

/** @type {(range: Range, max: number) => number[]} at most about `max` round numbers in the range */
export function ticks(range, max) {
  if (range.log) return decades(range, max);
  const raw = (range.high - range.low) / Math.max(1, max);
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map((factor) => factor * power).find((step) => step >= raw) ?? 10 * power;
  const found = [];
  for (let i = Math.ceil(range.low / step - 1e-9); i * step <= range.high + 1e-9 * step; i += 1) found.push(i * step);
  return found;
}

/** @type {(range: Range, max: number) => number[]} */
function decades({ low, high }, max) {
  const [first, last] = [Math.ceil(Math.log10(low) - 1e-9), Math.floor(Math.log10(high) + 1e-9)];
  const step = Math.max(1, Math.ceil((last - first + 1) / Math.max(1, max)));
  const found = [];
  for (let i = first; i <= last; i += 1) if ((i - first) % step === 0) found.push(10 ** i);
  return found;
}

const SUPERSCRIPTS = '⁰¹²³⁴⁵⁶⁷⁸⁹';

/** @type {(power: number) => string} */
function powerOfTen(power) {
  const digits = [...String(Math.abs(power))].map((digit) => SUPERSCRIPTS[Number(digit)]).join('');
  return `10${power < 0 ? '⁻' : ''}${digits}`;
}

/** @type {(value: number, log: boolean) => string} */
export function tickLabel(value, log) {
  if (log && (value >= 1e4 || value < 1e-2)) return powerOfTen(Math.round(Math.log10(value)));
  if (value !== 0 && Math.abs(value) < 1e-3) {
    const power = Math.floor(Math.log10(Math.abs(value) * (1 + 1e-9)));
    const digits = Number((value / 10 ** power).toPrecision(3));
    return `${digits === 1 ? '' : `${digits}·`}${powerOfTen(power)}`.replace('-', '−');
  }
  // Without the rounding error of a tick, and with all digits of a time on the clock of Unix.
  return String(Number(value.toPrecision(12))).replace('-', '−');
}

/**
 * Draws grid, ticks and labels. Draw curves after this, so that they are on top.
 * @param {Surface} surface
 * @param {Frame} frame
 * @param {Palette} colours
 * @param {{x?: boolean, y?: boolean, xLabel?: string, yTicks?: number, yUnit?: (value: number) => string}} [options] `x`,
 *   `y`: draw labels; `yUnit` formats the labels of y
 */
export function axes(surface, frame, colours, { x = true, y = true, xLabel = '', yTicks, yUnit } = {}) {
  const { left, top, width, height } = frame;
  surface.font = FONT;
  surface.lineWidth = 1;
  surface.setLineDash([]);
  surface.strokeStyle = colours.grid;
  surface.fillStyle = colours.muted;
  surface.textBaseline = 'middle';
  surface.textAlign = 'right';
  for (const tick of y ? ticks(frame.y, yTicks ?? Math.max(2, height / 34)) : []) {
    const at = Math.round(atY(frame, tick)) + 0.5;
    line(surface, left, at, left + width, at);
    surface.fillText(yUnit ? yUnit(tick) : tickLabel(tick, Boolean(frame.y.log)), left - 6, at);
  }
  surface.textAlign = 'center';
  surface.textBaseline = 'top';
  const labelEnd = xLabel ? left + width - 24 : Infinity;
  for (const tick of ticks(frame.x, Math.max(2, width / 70))) {
    const at = Math.round(atX(frame, tick)) + 0.5;
    line(surface, at, top, at, top + height);
    if (x && at < labelEnd) surface.fillText(tickLabel(tick, Boolean(frame.x.log)), at, top + height + 5);
  }
  if (x && xLabel) {
    surface.textAlign = 'right';
    surface.fillText(xLabel, left + width, top + height + 5);
  }
}

/** @type {(surface: Surface, x1: number, y1: number, x2: number, y2: number) => void} */
export function line(surface, x1, y1, x2, y2) {
  surface.beginPath();
  surface.moveTo(x1, y1);
  surface.lineTo(x2, y2);
  surface.stroke();
}

/**
 * Draws a curve. Of several samples in one pixel column, only the lowest and the highest are drawn.
 * @param {Surface} surface
 * @param {Frame} frame
 * @param {Float64Array} xs
 * @param {Float64Array} ys
 * @param {number} length
 * @param {{colour: string, width?: number, dash?: number[], floor?: number}} style
 */
export function curve(surface, frame, xs, ys, length, { colour, width = 1.6, dash = [], floor }) {
  if (length === 0) return;
  surface.save();
  surface.beginPath();
  surface.rect(frame.left, frame.top - 1, frame.width + 1, frame.height + 2);
  surface.clip();
  surface.strokeStyle = colour;
  surface.lineWidth = width;
  surface.lineJoin = 'round';
  surface.setLineDash(dash);
  surface.beginPath();
  const value = (/** @type {number} */ i) => (floor === undefined ? ys[i] : Math.max(floor, ys[i]));
  let pen = false;
  for (let i = 0; i < length; ) {
    const column = Math.floor(atX(frame, xs[i]));
    let [low, high, end] = [i, i, i + 1];
    while (end < length && Math.floor(atX(frame, xs[end])) === column) {
      if (value(end) < value(low)) low = end;
      if (value(end) > value(high)) high = end;
      end += 1;
    }
    for (const at of low === high ? [low] : low < high ? [low, high] : [high, low]) {
      if (Number.isNaN(value(at))) pen = false;
      else if (pen) surface.lineTo(atX(frame, xs[at]), atY(frame, value(at)));
      else surface.moveTo(atX(frame, xs[at]), atY(frame, value(at)));
      pen = pen || !Number.isNaN(value(at));
    }
    i = end;
  }
  surface.stroke();
  surface.restore();
}

/**
 * Draws a horizontal line with a label at its right end.
 * @param {Surface} surface
 * @param {Frame} frame
 * @param {number} value
 * @param {string} colour
 * @param {string} label
 */
export function level(surface, frame, value, colour, label) {
  const y = atY(frame, value);
  if (!(y >= frame.top - 1 && y <= frame.top + frame.height + 1)) return;
  surface.strokeStyle = colour;
  surface.fillStyle = colour;
  surface.lineWidth = 1.2;
  surface.setLineDash([6, 4]);
  line(surface, frame.left, y, frame.left + frame.width, y);
  surface.setLineDash([]);
  surface.font = FONT;
  surface.textAlign = 'right';
  surface.textBaseline = 'bottom';
  surface.fillText(label, frame.left + frame.width - 3, y - 2);
}

/** @type {(columns: Float64Array[], length: number) => {low: number, high: number}} smallest and largest value, without nan */
export function bounds(columns, length) {
  let [low, high] = [Infinity, -Infinity];
  for (const column of columns) {
    for (let i = 0; i < length; i += 1) {
      if (column[i] < low) low = column[i];
      if (column[i] > high) high = column[i];
    }
  }
  return { low, high };
}

/** @type {(text: string, surface: Surface, x: number, y: number, colours: Palette) => void} */
export function hint(text, surface, x, y, colours) {
  surface.font = FONT;
  surface.fillStyle = colours.muted;
  surface.textAlign = 'center';
  surface.textBaseline = 'middle';
  surface.fillText(text, x, y);
}
