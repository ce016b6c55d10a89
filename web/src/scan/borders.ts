// Edges with one triangle only: the rims of the scan's holes.  Drawn darker, they distinguish "not seen" from "flat".

/**
 * Positions (x y z pairs, ready for line segments) of the border edges of an indexed mesh.
 * `isSplit`: vertices may stand several times at one place, as texture coordinates require.
 *
 * The edges are in buckets by their lower vertex, some three in each: with a hash map a million triangles take seconds.
 */
export function borderEdges(positions: ArrayLike<number>, index: ArrayLike<number>, isSplit: boolean): Float32Array {
  const same = isSplit ? weld(positions) : null;
  const count = index.length;
  const nextOf = (corner: number): number => (corner % 3 === 2 ? corner - 2 : corner + 1);
  const vertexAt = (corner: number): number => (same ? same[index[corner]!]! : index[corner]!);
  const ends = new Uint32Array(positions.length / 3 + 1); // of the buckets; filled from their ends, they are their beginnings afterwards
  for (let corner = 0; corner < count; corner += 1) ends[Math.min(vertexAt(corner), vertexAt(nextOf(corner)))]! += 1;
  for (let vertex = 1; vertex < ends.length; vertex += 1) ends[vertex]! += ends[vertex - 1]!;
  const higher = new Uint32Array(count);
  const corners = new Uint32Array(count);
  for (let corner = count - 1; corner >= 0; corner -= 1) {
    const [a, b] = [vertexAt(corner), vertexAt(nextOf(corner))];
    const place = (ends[Math.min(a, b)]! -= 1);
    higher[place] = Math.max(a, b);
    corners[place] = corner;
  }
  const isBorder = new Uint8Array(count);
  for (let vertex = 0; vertex + 1 < ends.length; vertex += 1) {
    for (let i = ends[vertex]!; i < ends[vertex + 1]!; i += 1) {
      let uses = 0;
      for (let j = ends[vertex]!; j < ends[vertex + 1]!; j += 1) if (higher[j] === higher[i]) uses += 1;
      if (uses === 1) isBorder[corners[i]!] = 1;
    }
  }
  const points: number[] = [];
  for (let corner = 0; corner < count; corner += 1) {
    if (!isBorder[corner]) continue;
    for (const each of [corner, nextOf(corner)]) for (let axis = 0; axis < 3; axis += 1) points.push(positions[3 * index[each]! + axis]!);
  }
  return new Float32Array(points);
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
