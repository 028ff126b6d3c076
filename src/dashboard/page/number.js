// Numbers as text: a fixed number of digits, never “−0”, with units.

/** @typedef {number | null | undefined} Maybe */

/** @type {(text: string) => string} */
const withMinus = (text) => text.replace('-', '−');

/** @type {(value: Maybe, digits: number) => string} e.g. “−0.250”; “–” without a value */
export function fixed(value, digits) {
  if (value === null || value === undefined || Number.isNaN(value)) return '–';
  const text = value.toFixed(digits);
  return withMinus(Number(text) === 0 ? text.replace('-', '') : text);
}

/** @type {(value: Maybe) => string} two significant digits, e.g. “1.4e−12”; “–” without a value */
export function scientific(value) {
  if (value === null || value === undefined || Number.isNaN(value)) return '–';
  return value === 0 ? '0' : withMinus(value.toExponential(1).replace('e+', 'e'));
}

/** @type {(value: Maybe, unit: string, digits?: number) => string} three significant digits and a unit */
export function quantity(value, unit, digits = 3) {
  if (value === null || value === undefined || Number.isNaN(value)) return '–';
  const size = Math.abs(value);
  if (size === 0) return `0 ${unit}`;
  const text = size < 1e-4 || size >= 1e6 ? scientific(value) : withMinus(String(Number(value.toPrecision(digits))));
  return `${text} ${unit}`;
}

/** @type {(meters: Maybe) => string} a distance in mm or µm */
export function distance(meters) {
  if (meters === null || meters === undefined || Number.isNaN(meters)) return '–';
  const size = Math.abs(meters);
  if (size < 1e-7) return '0 mm';
  return size < 1e-4 ? quantity(meters * 1e6, 'µm', 2) : quantity(meters * 1e3, 'mm');
}

/** @type {(radians: Maybe) => string} an angle in degrees */
export function angle(radians) {
  if (radians === null || radians === undefined || Number.isNaN(radians)) return '–';
  const degrees = (radians * 180) / Math.PI;
  return Math.abs(degrees) < 1e-5 ? '0°' : quantity(degrees, '°', 2).replace(' °', '°');
}

/** @type {(micros: number) => string} */
export function microseconds(micros) {
  if (micros >= 1e6) return `${(micros / 1e6).toFixed(1)} s`;
  return micros >= 1000 ? `${Number((micros / 1000).toPrecision(3))} ms` : `${Number(micros.toPrecision(3))} µs`;
}
