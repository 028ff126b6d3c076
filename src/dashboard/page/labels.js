// Names of joints, short enough to stand next to a plot.

/** Approximate width of a character of the plots' font, px. */
const CHARACTER_WIDTH = 6.1;

/** Maximum width of the names, px. */
const MAX_WIDTH = 104;

/**
 * Returns the names without the words that all of them begin or end with: `shoulder_pan_joint` and `elbow_joint` become
 * `shoulder_pan` and `elbow`.
 * @param {string[]} names
 * @returns {string[]}
 */
export function jointLabels(names) {
  let words = names.map((name) => name.split('_'));
  for (const end of /** @type {const} */ (['first', 'last'])) {
    for (;;) {
      const at = (/** @type {string[]} */ parts) => (end === 'first' ? parts[0] : parts[parts.length - 1]);
      const isCommon = words.length > 1 && words.every((parts) => parts.length > 1 && at(parts) === at(words[0]));
      if (!isCommon) break;
      words = words.map((parts) => (end === 'first' ? parts.slice(1) : parts.slice(0, -1)));
    }
  }
  return words.map((parts) => shortened(parts.join('_')));
}

/** @type {(name: string) => string} */
function shortened(name) {
  const most = Math.floor(MAX_WIDTH / CHARACTER_WIDTH);
  return name.length > most ? `${name.slice(0, most - 1)}…` : name;
}

/** @type {(labels: string[]) => number} width of the column that holds the labels, px */
export function labelWidth(labels) {
  return Math.max(38, 10 + CHARACTER_WIDTH * Math.max(0, ...labels.map((label) => label.length)));
}
