// How much a scan without colours bends at each vertex: folds a shade darker and what stands out a shade brighter, so that
// nipples and the fold under a breast can be read on grey.
//
// Along an edge from i to j the normal curvature is about (n_j - n_i) (p_j - p_i) / |p_j - p_i|²; its mean over a vertex's
// edges is the mean curvature, above zero where the surface is convex.  Long edges weigh more: slivers say nothing.  A depth camera's noise bends more than a body does,
// so the means are spread over the surface (steps of averaging over neighbours) about as far as a nipple is wide.

const REACH = 0.0035; // metres, standard deviation of the spreading: half a nipple
const STEPS = { least: 1, most: 48 }; // of a mesh with edges of 0.5 mm as well: what is beyond is noise that is seen
const SHARPEST = 250; // 1/m, a radius of 4 mm: nothing on a body bends more, a spike of the scan does
const STRONG = 55; // 1/m at which three quarters of the shade are reached: a radius of 18 mm; a breast has 60 mm, a nipple 6

/** `positions` metres, outward triangles.  By vertex: 128 is flat, less a fold, more a ridge. */
export function reliefOf(positions: ArrayLike<number>, index: ArrayLike<number>): Uint8Array {
  const count = positions.length / 3;
  const normals = normalsOf(positions, index);
  const edges = new Float32Array(count); // how many lead to a vertex; an edge between two triangles counts twice everywhere
  const lengths = new Float32Array(count); // squared, of those edges together
  let bend: Float32Array = new Float32Array(count);
  let squares = 0;
  for (let i = 0; i < index.length; i += 1) {
    const a = index[i]!;
    const b = index[i % 3 === 2 ? i - 2 : i + 1]!;
    const [x, y, z] = [positions[3 * b]! - positions[3 * a]!, positions[3 * b + 1]! - positions[3 * a + 1]!, positions[3 * b + 2]! - positions[3 * a + 2]!];
    const square = x * x + y * y + z * z;
    if (square === 0) continue;
    const bends = (normals[3 * b]! - normals[3 * a]!) * x + (normals[3 * b + 1]! - normals[3 * a + 1]!) * y + (normals[3 * b + 2]! - normals[3 * a + 2]!) * z;
    bend[a]! += bends;
    bend[b]! += bends;
    lengths[a]! += square;
    lengths[b]! += square;
    edges[a]! += 1;
    edges[b]! += 1;
    squares += square;
  }
  for (let vertex = 0; vertex < count; vertex += 1) bend[vertex] = Math.min(SHARPEST, Math.max(-SHARPEST, bend[vertex]! / Math.max(lengths[vertex]!, 1e-12)));
  // Averaging with the neighbours, half and half, spreads by a quarter of an edge's square in each direction.
  const steps = Math.min(STEPS.most, Math.max(STEPS.least, Math.round(REACH ** 2 / (0.25 * Math.max(squares / Math.max(1, index.length), 1e-12)))));
  for (let step = 0; step < steps; step += 1) bend = spread(bend, index, edges);
  return Uint8Array.from(bend, (value) => 128 + Math.round(127 * Math.tanh(value / STRONG)));
}

function spread(values: Float32Array, index: ArrayLike<number>, edges: Float32Array): Float32Array {
  const sums = new Float32Array(values.length);
  for (let i = 0; i < index.length; i += 3) {
    const [a, b, c] = [index[i]!, index[i + 1]!, index[i + 2]!];
    const [u, v, w] = [values[a]!, values[b]!, values[c]!];
    sums[a]! += v + w;
    sums[b]! += w + u;
    sums[c]! += u + v;
  }
  for (let vertex = 0; vertex < values.length; vertex += 1) {
    const around = edges[vertex]!;
    sums[vertex] = around > 0 ? 0.5 * (values[vertex]! + sums[vertex]! / around) : 0;
  }
  return sums;
}

/** Unit, of the triangles around each vertex by their area. */
function normalsOf(positions: ArrayLike<number>, index: ArrayLike<number>): Float32Array {
  const normals = new Float32Array(positions.length);
  for (let i = 0; i < index.length; i += 3) {
    const [a, b, c] = [3 * index[i]!, 3 * index[i + 1]!, 3 * index[i + 2]!];
    const [ux, uy, uz] = [positions[b]! - positions[a]!, positions[b + 1]! - positions[a + 1]!, positions[b + 2]! - positions[a + 2]!];
    const [vx, vy, vz] = [positions[c]! - positions[a]!, positions[c + 1]! - positions[a + 1]!, positions[c + 2]! - positions[a + 2]!];
    const [x, y, z] = [uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx];
    for (const corner of [a, b, c]) {
      normals[corner]! += x;
      normals[corner + 1]! += y;
      normals[corner + 2]! += z;
    }
  }
  for (let i = 0; i < normals.length; i += 3) {
    const length = Math.hypot(normals[i]!, normals[i + 1]!, normals[i + 2]!) || 1;
    normals[i]! /= length;
    normals[i + 1]! /= length;
    normals[i + 2]! /= length;
  }
  return normals;
}
