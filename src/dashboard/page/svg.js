// A drawing surface with the canvas methods that the plots use. It writes SVG.

/** @type {(text: string) => string} */
export const escaped = (text) => text.replaceAll('&', '&amp;').replaceAll('<', '&lt;').replaceAll('"', '&quot;');

/** @type {(value: number) => string} */
const short = (value) => String(Math.round(value * 100) / 100);

const ANCHORS = { left: 'start', right: 'end', center: 'middle', start: 'start', end: 'end' };
const BASELINES = { top: 'hanging', middle: 'central', bottom: 'text-after-edge', hanging: 'hanging', alphabetic: 'auto', ideographic: 'auto' };

let clips = 0;

/** Replaces a `CanvasRenderingContext2D`; implements only the methods that the plots use. */
export class SvgSurface {
  constructor() {
    this.fillStyle = '#000';
    this.strokeStyle = '#000';
    this.lineWidth = 1;
    this.lineJoin = 'miter';
    this.lineCap = 'butt';
    this.globalAlpha = 1;
    this.font = '11px sans-serif';
    /** @type {CanvasTextAlign} */
    this.textAlign = 'start';
    /** @type {CanvasTextBaseline} */
    this.textBaseline = 'alphabetic';
    /** @type {number[]} */
    this.dash = [];
    this.path = '';
    this.text = '';
    /** @type {{open: number, dash: number[]}[]} open groups of each saved state */
    this.saved = [];
    this.open = 0;
  }

  /** @param {number[]} dash */
  setLineDash(dash) {
    this.dash = dash;
  }

  beginPath() {
    this.path = '';
  }

  /** @type {(x: number, y: number) => void} */
  moveTo(x, y) {
    this.path += `M${short(x)} ${short(y)}`;
  }

  /** @type {(x: number, y: number) => void} */
  lineTo(x, y) {
    this.path += `L${short(x)} ${short(y)}`;
  }

  /** @type {(x: number, y: number, r: number) => void} only complete circles */
  arc(x, y, r) {
    this.path += `M${short(x - r)} ${short(y)}a${short(r)} ${short(r)} 0 1 0 ${short(2 * r)} 0a${short(r)} ${short(r)} 0 1 0 ${short(-2 * r)} 0`;
  }

  /** @type {(x: number, y: number, width: number, height: number) => void} */
  rect(x, y, width, height) {
    this.path += `M${short(x)} ${short(y)}h${short(width)}v${short(height)}h${short(-width)}z`;
  }

  closePath() {
    this.path += 'z';
  }

  stroke() {
    const dash = this.dash.length > 0 ? ` stroke-dasharray="${this.dash.join(' ')}"` : '';
    this.text += `<path d="${this.path}" fill="none" stroke="${this.strokeStyle}" stroke-width="${this.lineWidth}" stroke-linejoin="round"${dash}${this.alpha}/>`;
  }

  fill() {
    this.text += `<path d="${this.path}" fill="${this.fillStyle}"${this.alpha}/>`;
  }

  get alpha() {
    return this.globalAlpha < 1 ? ` opacity="${this.globalAlpha}"` : '';
  }

  /** @type {(x: number, y: number, width: number, height: number) => void} */
  fillRect(x, y, width, height) {
    const [left, right] = [Math.min(x, x + width), Math.max(x, x + width)];
    if (!Number.isFinite(left) || !Number.isFinite(right)) return;
    this.text += `<rect x="${short(left)}" y="${short(y)}" width="${short(right - left)}" height="${short(height)}" fill="${this.fillStyle}"${this.alpha}/>`;
  }

  /** @type {(x: number, y: number, width: number, height: number) => void} */
  strokeRect(x, y, width, height) {
    this.beginPath();
    this.rect(x, y, width, height);
    this.stroke();
  }

  /** @type {(text: string, x: number, y: number) => void} */
  fillText(text, x, y) {
    const size = /(\d+)px/.exec(this.font)?.[1] ?? '11';
    const weight = /^(\d+) /.exec(this.font)?.[1];
    this.text += `<text x="${short(x)}" y="${short(y)}" font-size="${size}"${weight ? ` font-weight="${weight}"` : ''} text-anchor="${ANCHORS[this.textAlign]}" dominant-baseline="${BASELINES[this.textBaseline]}" fill="${this.fillStyle}">${escaped(text)}</text>`;
  }

  save() {
    this.saved.push({ open: this.open, dash: this.dash });
    this.open = 0;
  }

  restore() {
    this.text += '</g>'.repeat(this.open);
    const before = this.saved.pop();
    this.open = before?.open ?? 0;
    this.dash = before?.dash ?? [];
  }

  clip() {
    clips += 1;
    this.text += `<clipPath id="clip${clips}"><path d="${this.path}"/></clipPath><g clip-path="url(#clip${clips})">`;
    this.open += 1;
  }
}
