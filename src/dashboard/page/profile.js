// Set-points over time: their values, the same set-points for a run that starts later, and the opposite ones.

/**
 * @typedef {import('./types.js').Profile} Profile
 * @typedef {number | number[]} PerAxis one value for all rows, or one per row
 * @typedef {{time_s: number, value: PerAxis}} Point
 */

/** @type {<T>(values: T | T[], rows: number) => T[]} */
export function perRow(values, rows) {
  return Array.isArray(values) ? values : Array(rows).fill(values);
}

/**
 * Returns the value of a profile.
 * @param {Profile} profile
 * @param {number} rows
 * @param {number} time s
 * @returns {number[]} one value per row
 */
export function valueAt(profile, rows, time) {
  const list = (/** @type {PerAxis} */ values) => perRow(values, rows);
  switch (profile.kind) {
    case 'constant':
      return list(profile.value);
    case 'sine': {
      const since = Math.max(time, profile.start_time_s ?? -Infinity);
      const sine = Math.sin(profile.angular_frequency_rad_s * since + (profile.phase_rad ?? 0));
      const amplitude = list(profile.amplitude);
      return list(profile.offset).map((offset, row) => offset + amplitude[row] * sine);
    }
    case 'ramp': {
      const part = Math.max(0, Math.min(1, (time - (profile.start_time_s ?? 0)) / profile.duration_s));
      const end = list(profile.end);
      return list(profile.start).map((start, row) => start + part * (end[row] - start));
    }
    case 'steps': {
      const passed = profile.points.filter((point) => point.time_s <= time);
      return list((passed.at(-1) ?? profile.points[0]).value);
    }
    case 'waypoints': {
      const { times, values, rates } = splineOf(profile, rows);
      return values.map((column, row) => spline(times, column, rates[row], time));
    }
  }
}

/**
 * @typedef {object} Spline through the points of a profile
 * @property {number[]} times s
 * @property {number[][]} values per row
 * @property {number[][]} rates derivatives at the points, per row
 */

/** @type {WeakMap<Profile, Spline>} */
const splines = new WeakMap();

/** @type {(profile: Extract<Profile, {kind: 'waypoints'}>, rows: number) => Spline} */
function splineOf(profile, rows) {
  const known = splines.get(profile);
  if (known?.values.length === rows) return known;
  const times = profile.points.map(({ time_s }) => time_s);
  const values = Array.from({ length: rows }, (_, row) => profile.points.map(({ value }) => perRow(value, rows)[row]));
  const made = { times, values, rates: values.map((column) => (times.length > 1 ? clampedRates(times, column) : [0])) };
  splines.set(profile, made);
  return made;
}

/** @type {(times: number[], values: number[], rates: number[], time: number) => number} cubic spline, at rest at its ends */
function spline(times, values, rates, time) {
  const last = times.length - 1;
  if (time <= times[0] || last === 0) return values[0];
  if (time >= times[last]) return values[last];
  const i = times.findLastIndex((knot) => knot <= time);
  const h = times[i + 1] - times[i];
  const s = (time - times[i]) / h;
  const [s2, s3] = [s * s, s * s * s];
  return (2 * s3 - 3 * s2 + 1) * values[i] + (s3 - 2 * s2 + s) * h * rates[i]
    + (3 * s2 - 2 * s3) * values[i + 1] + (s3 - s2) * h * rates[i + 1];
}

/** @type {(times: number[], values: number[]) => number[]} derivatives at the points, zero at both ends */
function clampedRates(times, values) {
  const last = times.length - 1;
  const rates = Array(times.length).fill(0);
  const above = Array(times.length).fill(0);
  for (let i = 1; i < last; i += 1) {
    const [left, right] = [1 / (times[i] - times[i - 1]), 1 / (times[i + 1] - times[i])];
    const pivot = 2 * (left + right) - left * above[i - 1];
    const slopes = (values[i] - values[i - 1]) * left * left + (values[i + 1] - values[i]) * right * right;
    rates[i] = (3 * slopes - left * rates[i - 1]) / pivot;
    above[i] = right / pivot;
  }
  for (let i = last - 1; i > 0; i -= 1) rates[i] -= above[i] * rates[i + 1];
  return rates;
}

/** @type {(profile: Profile, time: number) => Profile} the profile for a clock that starts `time` s later */
export function shifted(profile, time) {
  switch (profile.kind) {
    case 'constant':
      return profile;
    case 'sine':
      return {
        ...profile,
        phase_rad: (profile.phase_rad ?? 0) + profile.angular_frequency_rad_s * time,
        ...(profile.start_time_s != null && { start_time_s: profile.start_time_s - time }),
      };
    case 'ramp':
      return { ...profile, start_time_s: (profile.start_time_s ?? 0) - time };
    default:
      return { ...profile, points: profile.points.map((point) => ({ ...point, time_s: point.time_s - time })) };
  }
}

/** @type {(profile: Profile) => Profile} the profile with the opposite values */
export function negated(profile) {
  const minus = (/** @type {PerAxis} */ values) => (Array.isArray(values) ? values.map((value) => -value) : -values);
  switch (profile.kind) {
    case 'constant':
      return { ...profile, value: minus(profile.value) };
    case 'sine':
      return { ...profile, offset: minus(profile.offset), amplitude: minus(profile.amplitude) };
    case 'ramp':
      return { ...profile, start: minus(profile.start), end: minus(profile.end) };
    default:
      return { ...profile, points: profile.points.map((point) => ({ ...point, value: minus(point.value) })) };
  }
}
