// The smallest singular value of a small matrix, from the eigenvalues of A Aᵀ by Jacobi rotations.

/** Number of sweeps; a 6 × 6 matrix converges after five. */
const SWEEPS = 10;

/** Returns the smallest singular value; infinite for a matrix without rows. @type {(rows: number[][]) => number} */
export function smallestSingularValue(rows) {
  const gram = rows.map((a) => rows.map((b) => a.reduce((sum, value, i) => sum + value * b[i], 0)));
  for (let sweep = 0; sweep < SWEEPS; sweep += 1) {
    for (let i = 0; i < rows.length; i += 1) {
      for (let k = i + 1; k < rows.length; k += 1) turn(gram, i, k);
    }
  }
  return Math.sqrt(Math.max(0, Math.min(...gram.map((row, i) => row[i]))));
}

/** Turns the plane of two axes so that the entry between them becomes zero. @type {(gram: number[][], i: number, k: number) => void} */
function turn(gram, i, k) {
  const off = gram[i][k];
  if (Math.abs(off) < 1e-300) return;
  const theta = (gram[k][k] - gram[i][i]) / (2 * off);
  const t = Math.sign(theta || 1) / (Math.abs(theta) + Math.hypot(theta, 1));
  const c = 1 / Math.hypot(t, 1);
  const s = t * c;
  for (const row of gram) [row[i], row[k]] = [c * row[i] - s * row[k], s * row[i] + c * row[k]];
  for (let j = 0; j < gram.length; j += 1) {
    [gram[i][j], gram[k][j]] = [c * gram[i][j] - s * gram[k][j], s * gram[i][j] + c * gram[k][j]];
  }
}
