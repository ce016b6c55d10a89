// Edges with one triangle only: the rims of the scan's holes.  Drawn darker, they distinguish "not seen" from "flat".

/**
 * Positions (x y z pairs, ready for line segments) of the border edges of an indexed mesh.
 * `isSplit`: vertices may stand several times at one place, as texture coordinates require.
 */
export function borderEdges(positions: ArrayLike<number>, index: ArrayLike<number>, isSplit: boolean): Float32Array {
  const same = isSplit ? weld(positions) : null;
  const count = positions.length / 3;
  const uses = new Map<number, number>(); // edge → corner that it starts at, or -1 when two triangles share it
  for (let corner = 0; corner < index.length; corner += 1) {
    const next = corner % 3 === 2 ? corner - 2 : corner + 1;
    const a = same ? same[index[corner]!]! : index[corner]!;
    const b = same ? same[index[next]!]! : index[next]!;
    const edge = a < b ? a * count + b : b * count + a;
    uses.set(edge, uses.has(edge) ? -1 : corner);
  }
  const corners = [...uses.values()].filter((corner) => corner >= 0);
  const points = new Float32Array(6 * corners.length);
  corners.forEach((corner, i) => {
    const next = corner % 3 === 2 ? corner - 2 : corner + 1;
    [corner, next].forEach((each, end) => {
      for (let axis = 0; axis < 3; axis += 1) points[6 * i + 3 * end + axis] = positions[3 * index[each]! + axis]!;
    });
  });
  return points;
}

/** For each vertex the first one at the same place: seams of a texture are no borders. */
function weld(positions: ArrayLike<number>): Int32Array {
  const count = positions.length / 3;
  const same = new Int32Array(count);
  const first = new Map<string, number>();
  for (let vertex = 0; vertex < count; vertex += 1) {
    const key = `${positions[3 * vertex]},${positions[3 * vertex + 1]},${positions[3 * vertex + 2]}`;
    const earlier = first.get(key);
    if (earlier === undefined) first.set(key, vertex);
    same[vertex] = earlier ?? vertex;
  }
  return same;
}
