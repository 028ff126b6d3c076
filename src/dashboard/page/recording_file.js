// Reads recordings of any program: CSV with `time_s` and one column per joint, JSON, and JSON lines.

/**
 * @typedef {object} Table a recording before its joints are known
 * @property {string[]} names of the columns; empty if the file does not name its joints
 * @property {number} joints number of joints of a file that does not name them; they are its first columns
 * @property {number[]} times s
 * @property {(column: number, row: number) => unknown} cell
 * @property {(row: number) => string} place of a row, for messages
 */

/** Largest size of a file, bytes, and the largest number of rows that are kept. */
export const MAX_BYTES = 50_000_000;
const MAX_ROWS = 20_000;

/** Names of the column of the time, s. */
const TIMES = ['time_s', 'time', 't'];

/** Largest number of columns that a message names. */
const MAX_NAMES = 8;

/** Returns the text of a file; spreadsheets also write UTF-16, with a mark of it. @type {(bytes: ArrayBuffer) => string} */
export function textOf(bytes) {
  const [first, second] = new Uint8Array(bytes);
  const encoding = first === 0xff && second === 0xfe ? 'utf-16le' : first === 0xfe && second === 0xff ? 'utf-16be' : 'utf-8';
  return new TextDecoder(encoding).decode(bytes);
}

/** Reads a file. @type {(file: string, text: string) => Table} */
export function readTable(file, text) {
  const start = text.trimStart();
  const table = start.startsWith('{') || start.startsWith('[') ? fromJson(file, start) : fromCsv(file, text);
  if (table.times.length < 2) throw new Error(`${file} has ${table.times.length} rows; a recording needs two at least`);
  const bad = table.times.findIndex((time, row) => !Number.isFinite(time) || (row > 0 && time <= table.times[row - 1]));
  if (bad >= 0) throw new Error(`${file}, ${table.place(bad)}: the time must be a number of seconds that grows from row to row`);
  return thinned(table);
}

/** Leaves out rows of a long recording. @type {(table: Table) => Table} */
function thinned(table) {
  const { times, cell, place } = table;
  const step = Math.ceil(times.length / MAX_ROWS);
  if (step === 1) return table;
  return { ...table, times: times.filter((_, row) => row % step === 0), cell: (column, row) => cell(column, step * row), place: (row) => place(step * row) };
}

/** Where a comma does not separate cells, it is the decimal comma of spreadsheets. @type {(file: string, text: string) => Table} */
function fromCsv(file, text) {
  const lines = text.split(/\r?\n/);
  const kept = lines.flatMap((line, i) => (line.trim() === '' || line.startsWith('#') ? [] : [i]));
  const header = lines[kept[0]] ?? '';
  const separator = [',', ';', '\t'].find((mark) => header.includes(mark)) ?? ',';
  const wordsOf = (/** @type {string} */ line) => line.split(separator).map((word) => word.trim().replace(/^"(.*)"$/, '$1'));
  const names = wordsOf(header);
  const cellsOf = (/** @type {string} */ line) => (separator === ',' ? wordsOf(line) : wordsOf(line).map((word) => word.replace(',', '.')));
  const time = names.findIndex((name) => TIMES.includes(name));
  if (time < 0) throw new Error(`${file} has no column time_s; its first line must name time_s and the joints, and starts with “${header.slice(0, 60)}”`);
  // The cells of one row at a time: those of a long file would need much memory.
  let shown = { row: -1, cells: /** @type {string[]} */ ([]) };
  const cell = (/** @type {number} */ column, /** @type {number} */ row) => {
    if (shown.row !== row) shown = { row, cells: cellsOf(lines[kept[row + 1]]) };
    return shown.cells[column];
  };
  const times = Array.from({ length: Math.max(0, kept.length - 1) }, (_, row) => numberOf(cell(time, row)));
  return { names, joints: 0, times, cell, place: (row) => `line ${kept[row + 1] + 1}` };
}

/** @type {(file: string, text: string) => Table} */
function fromJson(file, text) {
  const content = /** @type {any} */ (parsed(file, text));
  const isList = Array.isArray(content);
  const times = isList ? content.map((row) => row?.time_s) : content.time_s;
  const positions = isList ? content.map((row) => row?.joint_position) : content.joint_position;
  const targets = isList ? content.map((row) => row?.target_position) : (content.target_position ?? []);
  if (!Array.isArray(times) || !Array.isArray(positions)) {
    throw new Error(`${file} needs the lists time_s and joint_position, or lines with these fields`);
  }
  const joints = isList ? [] : content.joint_names;
  const names = Array.isArray(joints) && joints.length > 0 ? [...joints.map(String), ...TARGETS] : [];
  const width = names.length > 0 ? names.length - TARGETS.length : (positions[0]?.length ?? 0);
  const cell = (/** @type {number} */ column, /** @type {number} */ row) => (column < width ? positions[row]?.[column] : targets?.[row]?.[column - width]);
  return { names, joints: names.length > 0 ? 0 : width, times: times.map(numberOf), cell, place: (row) => `row ${row + 1}` };
}

/** Reads JSON, or one JSON value per line. @type {(file: string, text: string) => unknown} */
function parsed(file, text) {
  try {
    return JSON.parse(text);
  } catch (error) {
    const lines = text.split('\n').filter((line) => line.trim() !== '');
    try {
      return lines.map((line) => JSON.parse(line));
    } catch {
      throw new Error(`${file} is neither JSON nor JSON lines: ${error instanceof Error ? error.message : error}`);
    }
  }
}

/** Columns of the target of the tool, base frame, m. */
export const TARGETS = ['target_x_m', 'target_y_m', 'target_z_m'];

/** Returns a number; NaN for an empty cell or another text. @type {(cell: unknown) => number} */
export function numberOf(cell) {
  if (typeof cell === 'number') return cell;
  return typeof cell === 'string' && cell.trim() !== '' ? Number(cell) : NaN;
}

/** Returns the columns of the joints of a robot; null if one is missing. @type {(names: string[], joints: string[]) => number[] | null} */
export function jointColumns(names, joints) {
  const columns = joints.map((joint) => {
    const known = [joint, `position_${joint}_rad`, `position_${joint}_m`, `${joint}_rad`, `${joint}_m`];
    return names.findIndex((name) => known.includes(name));
  });
  return columns.every((column) => column >= 0) ? columns : null;
}

/** @type {(names: string[]) => string} */
export function listed(names) {
  return `${names.slice(0, MAX_NAMES).join(', ')}${names.length > MAX_NAMES ? `, … (${names.length})` : ''}`;
}
