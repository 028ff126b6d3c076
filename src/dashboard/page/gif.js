// Encodes films as GIF89a: one palette by median cut, only what changes from picture to picture, LZW.

/**
 * @typedef {object} Palette
 * @property {Uint8Array} colours red, green and blue of 256 colours
 * @property {Uint8Array} index of each colour of 16 bits
 *
 * @typedef {{pixels: Uint16Array, delay: number}} Picture colours of 16 bits, row by row; time until the next picture, 1/100 s
 */

/** Number of colours; one more index stands for pixels that do not change. */
const COLOURS = 255;
const UNCHANGED = 255;

/** Number of different colours of 16 bits: 5 of red, 6 of green, 5 of blue. */
export const DEPTH = 65_536;

/** Bits of a pixel, and the largest code of LZW. */
const BITS = 8;
const LAST_CODE = 4095;

/** Shift and mask of red, green and blue in 16 bits. */
const PARTS = [[11, 31], [5, 63], [0, 31]];

/** Converts red, green, blue and opacity to 16 bits per pixel. @type {(data: Uint8ClampedArray) => Uint16Array} */
export function toPixels(data) {
  const pixels = new Uint16Array(data.length / 4);
  for (let i = 0; i < pixels.length; i += 1) pixels[i] = ((data[4 * i] >> 3) << 11) | ((data[4 * i + 1] >> 2) << 5) | (data[4 * i + 2] >> 3);
  return pixels;
}

/** Returns the palette of a film: divides the colours that occur by median cut. @type {(counts: Uint32Array) => Palette} `counts`: pixels by colour of 16 bits */
export function paletteOf(counts) {
  /** @type {number[]} */
  const used = [];
  counts.forEach((count, colour) => count > 0 && used.push(colour));
  let boxes = [boxOf(used, counts)];
  while (boxes.length < COLOURS) {
    const widest = boxes.reduce((best, box) => (box.weight > best.weight ? box : best));
    if (widest.weight === 0) break;
    boxes = [...boxes.filter((box) => box !== widest), ...halves(widest, counts)];
  }
  const colours = new Uint8Array(3 * 256);
  const index = new Uint8Array(DEPTH);
  boxes.forEach(({ members }, i) => {
    const total = members.reduce((sum, colour) => sum + counts[colour], 0) || 1;
    PARTS.forEach(([shift, mask], part) => {
      const sum = members.reduce((sum, colour) => sum + ((colour >> shift) & mask) * counts[colour], 0);
      colours[3 * i + part] = Math.round((255 * sum) / (mask * total));
    });
    for (const colour of members) index[colour] = i;
  });
  return { colours, index };
}

/** @typedef {{members: number[], part: number, weight: number}} Box colours, the part in which they differ most, and the need to divide them */

/** @type {(members: number[], counts: Uint32Array) => Box} */
function boxOf(members, counts) {
  let total = 0;
  const [low, high] = [[Infinity, Infinity, Infinity], [0, 0, 0]];
  for (const colour of members) {
    total += counts[colour];
    PARTS.forEach(([shift, mask], part) => {
      const value = ((colour >> shift) & mask) / mask;
      low[part] = Math.min(low[part], value);
      high[part] = Math.max(high[part], value);
    });
  }
  const sizes = high.map((value, part) => value - low[part]);
  const part = sizes.indexOf(Math.max(...sizes));
  // The root of the number keeps small bodies from losing their colours to the large background.
  return { members, part, weight: members.length > 1 ? sizes[part] * Math.sqrt(total) : 0 };
}

/** @type {(box: Box, counts: Uint32Array) => Box[]} */
function halves({ members, part }, counts) {
  const [shift, mask] = PARTS[part];
  const sorted = [...members].sort((a, b) => ((a >> shift) & mask) - ((b >> shift) & mask));
  const half = sorted.reduce((sum, colour) => sum + counts[colour], 0) / 2;
  let [sum, at] = [0, 0];
  while (at < sorted.length - 1 && (at === 0 || sum + counts[sorted[at]] <= half)) {
    sum += counts[sorted[at]];
    at += 1;
  }
  return [sorted.slice(0, at), sorted.slice(at)].map((list) => boxOf(list, counts));
}

/** @type {(value: number) => number[]} two bytes, the lower one first */
const word = (value) => [value & 255, value >> 8];

/** Returns the start of a film that goes round and round. @type {(width: number, height: number, palette: Palette) => Uint8Array<ArrayBuffer>} */
export function header(width, height, { colours }) {
  const loop = [0x21, 0xff, 11, ...Array.from('NETSCAPE2.0', (letter) => letter.charCodeAt(0)), 3, 1, 0, 0, 0];
  return Uint8Array.from([...Array.from('GIF89a', (letter) => letter.charCodeAt(0)), ...word(width), ...word(height), 0xf7, 0, 0, ...colours, ...loop]);
}

/** The end of a film. */
export const TRAILER = Uint8Array.of(0x3b);

/** Returns one picture of a film. @type {(width: number, picture: Picture, before: Uint16Array | null, palette: Palette) => Uint8Array<ArrayBuffer>} */
export function encoded(width, { pixels, delay }, before, { index }) {
  const { left, top, right, bottom } = changed(width, pixels, before);
  const [across, down] = [right - left, bottom - top];
  const indices = new Uint8Array(across * down);
  for (let y = 0, at = 0; y < down; y += 1) {
    for (let x = 0, i = (top + y) * width + left; x < across; x += 1, i += 1, at += 1) indices[at] = before && before[i] === pixels[i] ? UNCHANGED : index[pixels[i]];
  }
  const control = [0x21, 0xf9, 4, 0x05, ...word(Math.min(65_535, delay)), UNCHANGED, 0];
  const place = [0x2c, ...word(left), ...word(top), ...word(across), ...word(down), 0, BITS];
  const data = compressed(indices);
  const bytes = new Uint8Array(control.length + place.length + data.length);
  bytes.set([...control, ...place]);
  bytes.set(data, control.length + place.length);
  return bytes;
}

/** Returns the rectangle of the pixels that differ; one pixel if none does. @type {(width: number, pixels: Uint16Array, before: Uint16Array | null) => {left: number, top: number, right: number, bottom: number}} */
function changed(width, pixels, before) {
  const height = pixels.length / width;
  if (!before) return { left: 0, top: 0, right: width, bottom: height };
  const found = { left: width, top: height, right: 0, bottom: 0 };
  for (let y = 0, i = 0; y < height; y += 1) {
    for (let x = 0; x < width; x += 1, i += 1) {
      if (before[i] === pixels[i]) continue;
      if (x < found.left) found.left = x;
      if (x >= found.right) found.right = x + 1;
      if (y < found.top) found.top = y;
      found.bottom = y + 1;
    }
  }
  return found.right > 0 ? found : { left: 0, top: 0, right: 1, bottom: 1 };
}

/** Compresses indices by LZW with codes of growing width, in blocks of at most 255 bytes. @type {(indices: Uint8Array) => Uint8Array} */
function compressed(indices) {
  const [clear, end] = [1 << BITS, (1 << BITS) + 1];
  const out = new BitWriter();
  /** Code of a known string and its next index; 0: unknown. */
  const codes = new Uint16Array((LAST_CODE + 1) << BITS);
  let [next, width, prefix] = [end + 1, BITS + 1, indices[0]];
  out.write(clear, width);
  for (let i = 1; i < indices.length; i += 1) {
    const key = (prefix << BITS) | indices[i];
    if (codes[key] > 0) {
      prefix = codes[key];
      continue;
    }
    out.write(prefix, width);
    prefix = indices[i];
    if (next > LAST_CODE) {
      out.write(clear, width);
      codes.fill(0);
      [next, width] = [end + 1, BITS + 1];
      continue;
    }
    codes[key] = next;
    // The reader adds its codes one step later.
    if (next === 1 << width) width += 1;
    next += 1;
  }
  out.write(prefix, width);
  // The reader adds a code for the last string, too, which may widen the end code.
  if (next === 1 << width && width < 12) width += 1;
  out.write(end, width);
  return out.blocks();
}

/** Bits, the lowest first. */
class BitWriter {
  constructor() {
    this.bytes = new Uint8Array(4096);
    this.length = 0;
    this.pending = 0;
    this.count = 0;
  }

  /** @param {number} value @param {number} width bits */
  write(value, width) {
    this.pending |= value << this.count;
    this.count += width;
    while (this.count >= 8) {
      this.push(this.pending & 255);
      this.pending >>>= 8;
      this.count -= 8;
    }
  }

  /** @param {number} byte */
  push(byte) {
    if (this.length === this.bytes.length) {
      const longer = new Uint8Array(2 * this.length);
      longer.set(this.bytes);
      this.bytes = longer;
    }
    this.bytes[this.length] = byte;
    this.length += 1;
  }

  /** Returns blocks that begin with their lengths, and an empty last one. */
  blocks() {
    if (this.count > 0) this.push(this.pending & 255);
    const count = Math.ceil(this.length / 255);
    const blocks = new Uint8Array(this.length + count + 1);
    for (let i = 0; i < count; i += 1) {
      const part = this.bytes.subarray(255 * i, Math.min(this.length, 255 * (i + 1)));
      blocks[256 * i] = part.length;
      blocks.set(part, 256 * i + 1);
    }
    return blocks;
  }
}
