// Fields for numbers: a number that the service would refuse is refused here, with words beside the field.

/**
 * @typedef {object} Range
 * @property {number} [count] of numbers; one if left out
 * @property {number} [least] zero if left out
 * @property {number} [most] the largest number of the service if left out
 * @property {boolean} [isOpen] whether the smallest number is not allowed itself
 */

/** Largest number in a request to the service. */
const LARGEST = 1e9;

/** Reads the numbers of a field, separated by spaces or commas; if it does not accept them, says what it accepts and returns null. @type {(field: HTMLInputElement, range?: Range) => number[] | null} */
export function read(field, { count = 1, least = 0, most = LARGEST, isOpen = false } = {}) {
  const values = field.value.split(/[\s,;]+/).filter(Boolean).map((word) => Number(word.replace('−', '-')));
  const isAccepted = values.length === count && values.every((value) => value <= most && (isOpen ? value > least : value >= least));
  const what = count === 1 ? 'a number' : `${count} numbers`;
  show(field, isAccepted ? '' : `Give ${what} ${isOpen ? 'above' : 'from'} ${text(least)} ${isOpen ? 'up ' : ''}to ${text(most)}.`);
  return isAccepted ? values : null;
}

/** Shows beside a field why it is refused; an empty text accepts it. @type {(field: HTMLInputElement, refusal: string) => void} */
function show(field, refusal) {
  const label = field.closest('label') ?? field;
  const shown = label.nextElementSibling;
  if (shown?.classList.contains('refusal')) shown.remove();
  field.ariaInvalid = String(refusal !== '');
  field.removeAttribute('aria-describedby');
  if (!refusal) return;
  field.id ||= `field-${crypto.getRandomValues(new Uint32Array(1))[0]}`;
  const note = document.createElement('p');
  Object.assign(note, { className: 'refusal', id: `${field.id}-refusal`, role: 'alert', textContent: refusal });
  label.after(note);
  field.setAttribute('aria-describedby', note.id);
}

/** Accepts a field that is empty. @type {(field: HTMLInputElement) => void} */
export const accept = (field) => show(field, '');

/** @type {(value: number) => string} */
function text(value) {
  const size = Math.abs(value);
  return (size !== 0 && (size < 1e-3 || size >= 1e5) ? value.toExponential().replace('e+', 'e') : String(value)).replaceAll('-', '−');
}
