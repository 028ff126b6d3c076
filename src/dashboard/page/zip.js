// Reads zip files: stored and deflated entries, without encryption.

/** Largest size of all entries together, bytes, and largest number of entries. */
const MAX_BYTES = 400_000_000;
const MAX_ENTRIES = 5000;

/** Signatures of the end record and of an entry of the directory, and the length of the end record without comment, bytes. */
const END = 0x06054b50;
const ENTRY = 0x02014b50;
const END_LENGTH = 22;

/**
 * @typedef {{name: string, isDeflated: boolean, packed: number, size: number, at: number}} Entry
 */

/** Returns the files of a zip file by path. Throws an error with the reason if it is not readable. @type {(zip: File) => Promise<Map<string, File>>} */
export async function unzip(zip) {
  const data = await zip.arrayBuffer();
  try {
    const entries = directory(new DataView(data)).filter(({ name }) => !name.endsWith('/') && !name.startsWith('__MACOSX/'));
    if (entries.reduce((sum, { size }) => sum + size, 0) > MAX_BYTES) throw new Error(`its files have more than ${MAX_BYTES / 1e6} MB`);
    const files = await Promise.all(entries.map(async (entry) => /** @type {[string, File]} */ ([entry.name, await content(data, entry)])));
    return new Map(files);
  } catch (error) {
    const reason = error instanceof RangeError ? 'it ends too early' : error instanceof Error ? error.message : String(error);
    throw new Error(`${zip.name} is not readable: ${reason}`);
  }
}

/** @type {(view: DataView) => Entry[]} */
function directory(view) {
  let end = view.byteLength - END_LENGTH;
  while (end >= 0 && view.getUint32(end, true) !== END) end -= 1;
  if (end < 0) throw new Error('it is not a zip file');
  const count = view.getUint16(end + 10, true);
  let at = view.getUint32(end + 16, true);
  if (at === 0xffffffff) throw new Error('it has the format ZIP64');
  if (count > MAX_ENTRIES) throw new Error(`it has more than ${MAX_ENTRIES} files`);
  return Array.from({ length: count }, () => {
    const { entry, next } = readEntry(view, at);
    at = next;
    return entry;
  });
}

/** @type {(view: DataView, at: number) => {entry: Entry, next: number}} */
function readEntry(view, at) {
  if (view.getUint32(at, true) !== ENTRY) throw new Error('its directory is broken');
  const [flags, method] = [view.getUint16(at + 8, true), view.getUint16(at + 10, true)];
  const [name, extra, comment] = [28, 30, 32].map((place) => view.getUint16(at + place, true));
  const text = new TextDecoder().decode(new Uint8Array(view.buffer, at + 46, name));
  if (flags & 1) throw new Error(`${text} is encrypted`);
  if (method !== 0 && method !== 8) throw new Error(`${text} is packed by method ${method}`);
  const [packed, size, header] = [20, 24, 42].map((place) => view.getUint32(at + place, true));
  return { entry: { name: text, isDeflated: method === 8, packed, size, at: header }, next: at + 46 + name + extra + comment };
}

/** @type {(data: ArrayBuffer, entry: Entry) => Promise<File>} */
async function content(data, { name, isDeflated, packed, size, at }) {
  const view = new DataView(data);
  const start = at + 30 + view.getUint16(at + 26, true) + view.getUint16(at + 28, true);
  const bytes = new Uint8Array(data, start, packed);
  const file = name.replace(/^.*\//, '');
  if (!isDeflated) return new File([bytes], file);
  const unpacked = await new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream('deflate-raw'))).arrayBuffer();
  if (unpacked.byteLength !== size) throw new Error(`${name} has another size than stated`);
  return new File([unpacked], file);
}
