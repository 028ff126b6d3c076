// How fast and how finely the scene is drawn: as fast as the screen with WebGL, with fewer pixels where that is too slow.

/** Pixels per CSS pixel that are tried, finest first. */
const DENSITIES = [2, 1.5, 1, 0.7];

/** Number of drawings that are measured, and the time per drawing above which fewer pixels are drawn, ms. */
const MEASURED = 12;
const SLOW = 30;

/** Longest pause between two drawings of one motion, ms: longer ones are rests. */
const REST = 3000;

export class Pace {
  constructor() {
    this.level = 0;
    this.last = 0;
    /** Times between drawings, ms. @type {number[]} */
    this.times = [];
  }

  /** Returns the pixels per CSS pixel. */
  get density() {
    return Math.min(DENSITIES[this.level], Math.max(0.5, devicePixelRatio || 1));
  }

  /** Notes a drawing. @param {number} now ms */
  note(now) {
    const elapsed = now - this.last;
    this.last = now;
    if (elapsed > REST || document.hidden) {
      this.times = [];
      return;
    }
    this.times.push(elapsed);
    if (this.times.length < MEASURED) return;
    const middle = this.times.sort((a, b) => a - b)[MEASURED / 2];
    const before = this.density;
    while (middle > SLOW && this.level + 1 < DENSITIES.length && this.density === before) this.level += 1;
    this.times = [];
  }
}
