// Eigenvalues and eigenvectors of a small symmetric matrix by Jacobi's rotations: Golub & Van Loan, Matrix Computations,
// 8.5.  Twelve rows are the most that is asked here, and for so few nothing is steadier.

export interface Eigen {
  readonly values: readonly number[]; // rising
  readonly vectors: readonly (readonly number[])[]; // unit, one for each value
}

const SWEEPS = 60; // eight are enough for twelve rows; what is not done by then is rounding

export function symmetricEigen(matrix: readonly (readonly number[])[]): Eigen {
  const count = matrix.length;
  const a = matrix.map((row) => [...row]);
  const v = matrix.map((_, i) => matrix.map((_, k) => (i === k ? 1 : 0))); // columns
  for (let sweep = 0; sweep < SWEEPS; sweep += 1) {
    let [off, all] = [0, 0];
    for (let i = 0; i < count; i += 1) for (let k = 0; k < count; k += 1) {
      all += a[i]![k]! ** 2;
      if (i !== k) off += a[i]![k]! ** 2;
    }
    if (off <= 1e-30 * all) break;
    for (let p = 0; p < count - 1; p += 1) for (let q = p + 1; q < count; q += 1) rotate(a, v, p, q);
  }
  const order = a.map((row, i) => ({ value: row[i]!, i })).sort((one, other) => one.value - other.value);
  return { values: order.map(({ value }) => value), vectors: order.map(({ i }) => v.map((row) => row[i]!)) };
}

/** Makes a[p][q] zero. */
function rotate(a: number[][], v: number[][], p: number, q: number): void {
  const apq = a[p]![q]!;
  if (apq === 0) return;
  const theta = (a[q]![q]! - a[p]![p]!) / (2 * apq);
  const t = (theta < 0 ? -1 : 1) / (Math.abs(theta) + Math.hypot(theta, 1));
  const c = 1 / Math.hypot(t, 1);
  const s = t * c;
  for (const row of a) [row[p], row[q]] = [c * row[p]! - s * row[q]!, s * row[p]! + c * row[q]!];
  const [rowP, rowQ] = [[...a[p]!], [...a[q]!]];
  for (let k = 0; k < a.length; k += 1) {
    a[p]![k] = c * rowP[k]! - s * rowQ[k]!;
    a[q]![k] = s * rowP[k]! + c * rowQ[k]!;
  }
  for (const row of v) [row[p], row[q]] = [c * row[p]! - s * row[q]!, s * row[p]! + c * row[q]!];
}
