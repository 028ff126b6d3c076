// Records the scene as a GIF film of bounded length and size.

import { DEPTH, TRAILER, encoded, header, paletteOf, toPixels } from './gif.js';
import { quantity } from './number.js';

/** Smallest time between two pictures and the longest film, ms; the largest width and height, px, and size, bytes. */
const BETWEEN = 100;
export const LONGEST = 15_000;
const LARGEST = 560;
const MAX_BYTES = 16_000_000;

export class GifRecorder {
  /**
   * @param {import('./scene.js').Scene} scene
   * @param {(film: Blob, text: string) => void} onFilm `text`: what it holds
   * @param {(progress: number | null) => void} onChange called when recording starts or ends, and with the part that is encoded
   */
  constructor(scene, onFilm, onChange) {
    this.scene = scene;
    this.onFilm = onFilm;
    this.onChange = onChange;
    this.large = document.createElement('canvas');
    this.small = document.createElement('canvas');
    /** @type {{pixels: Uint16Array, time: number}[]} */
    this.pictures = [];
    this.counts = new Uint32Array(DEPTH);
    /** @type {'idle' | 'recording' | 'encoding'} */
    this.state = 'idle';
    this.started = 0;
  }

  get isRecording() {
    return this.state === 'recording';
  }

  /** Starts a film, or ends and encodes it. */
  async toggle() {
    if (this.state === 'encoding') return;
    if (this.state === 'recording') {
      await this.finish();
      return;
    }
    this.state = 'recording';
    this.started = performance.now();
    this.small.width = 0;
    this.onChange(null);
    // While nothing is drawn, no picture ends it.
    setTimeout(() => {
      if (this.state === 'recording' && performance.now() - this.started >= LONGEST) void this.finish();
    }, LONGEST + BETWEEN);
    this.addPicture();
  }

  /** Adds the picture that was just drawn, if it is time for one. */
  addPicture() {
    if (this.state !== 'recording') return;
    const now = performance.now();
    if (now - this.started >= LONGEST) {
      void this.finish();
      return;
    }
    if (now - (this.pictures.at(-1)?.time ?? -Infinity) < BETWEEN) return;
    this.scene.paint(this.large);
    // A window that changes its size is fitted to the first picture.
    if (this.small.width === 0) {
      const factor = Math.min(1, LARGEST / Math.max(this.large.width, this.large.height));
      this.small.width = Math.max(1, Math.round(this.large.width * factor));
      this.small.height = Math.max(1, Math.round(this.large.height * factor));
    }
    const { width, height } = this.small;
    const context = this.small.getContext('2d', { willReadFrequently: true });
    if (!context) return;
    context.imageSmoothingQuality = 'high';
    context.drawImage(this.large, 0, 0, width, height);
    const pixels = toPixels(context.getImageData(0, 0, width, height).data);
    for (const pixel of pixels) this.counts[pixel] += 1;
    this.pictures.push({ pixels, time: now });
  }

  /** Encodes the film picture by picture, so that the page goes on. */
  async finish() {
    this.state = 'encoding';
    const ended = performance.now();
    const { pictures, counts, small: { width, height } } = this;
    this.pictures = [];
    this.counts = new Uint32Array(DEPTH);
    this.onChange(0);
    try {
      await this.encode(pictures, counts, width, height, ended);
    } finally {
      this.state = 'idle';
      this.onChange(null);
    }
  }

  /** @type {(pictures: {pixels: Uint16Array, time: number}[], counts: Uint32Array, width: number, height: number, ended: number) => Promise<void>} `ended`: ms */
  async encode(pictures, counts, width, height, ended) {
    if (pictures.length === 0) throw new Error('no picture was drawn');
    const palette = paletteOf(counts);
    const parts = [header(width, height, palette)];
    let size = parts[0].length;
    let shown = 0;
    for (const [i, { pixels, time }] of pictures.entries()) {
      const delay = Math.max(2, Math.round(((pictures[i + 1]?.time ?? ended) - time) / 10));
      const part = encoded(width, { pixels, delay }, pictures[i - 1]?.pixels ?? null, palette);
      if (size + part.length > MAX_BYTES) break;
      parts.push(part);
      size += part.length;
      shown += 1;
      this.onChange((i + 1) / pictures.length);
      await new Promise((resolve) => { setTimeout(resolve); });
    }
    const cut = shown < pictures.length ? `; ${pictures.length - shown} more would exceed ${MAX_BYTES / 1e6} MB` : '';
    this.onFilm(new Blob([...parts, TRAILER], { type: 'image/gif' }), `${shown} ${shown === 1 ? 'picture' : 'pictures'}, ${quantity(size / 1e6, 'MB', 2)}${cut}`);
  }
}
