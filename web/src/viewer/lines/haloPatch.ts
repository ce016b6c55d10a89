// The skin within so many millimetres of lines and points: the triangles that may lie there, and for each of them the few pieces
// of the lines that decide which of its pixels do.  Lying in the skin's own triangles, a wide band neither sinks into a fold nor
// covers itself; the pixels' own distances draw its edge, so that it is as sharp close up as from afar.
import { Box3, type BufferGeometry, type Color, Vector3 } from "three";
import type { MeshBVH } from "three-mesh-bvh";

/** A polyline or one point with its radii; metres, in the skin's axes. */
export interface Banded {
  readonly points: Float32Array; // x y z in a row
  readonly normals: Float32Array; // of the skin there
  readonly radii: Float32Array; // per point; NaN where it is not known
  readonly isClosed: boolean;
  readonly tint: Color;
}

/** Pieces of the lines, from point to point. */
export interface Pieces {
  readonly count: number;
  /** three rows of four of each: where it begins and its radius there, where it ends and its radius there, its colour and 1 where the radius is not known */
  readonly texels: Float32Array;
  readonly normals: Float32Array;
}

/** Corners of the triangles, and of each of them which of `entries` decide. */
export interface Patch {
  readonly position: Float32Array;
  readonly range: Float32Array; // per corner: the first one and how many
  readonly entries: Float32Array; // indices of pieces
}

const UNKNOWN = 0.01; // metres to each side that are hatched where no radius is known
const FACING = 0.2; // cosine: skin that looks another way is an arm beside the chest, or the far side of a fold
const EDGE = 0.003; // metres: farther inside a band no pixel belongs to its edge
const STEEP = 1.3; // how much faster than the distance the depth in a band may change, for its radius changes too
const RUN = 8; // pieces that the skin is asked for at once

export function piecesOf(lines: readonly Banded[]): Pieces {
  const texels: number[] = [];
  const normals: number[] = [];
  for (const { points, normals: out, radii, isClosed, tint } of lines) {
    const count = radii.length;
    const pieces = count === 1 || isClosed ? count : count - 1;
    for (let i = 0; i < pieces; i += 1) {
      const next = (i + 1) % count;
      const isKnown = !Number.isNaN(radii[i]!) && !Number.isNaN(radii[next]!);
      for (const end of [i, next]) texels.push(points[3 * end]!, points[3 * end + 1]!, points[3 * end + 2]!, isKnown ? radii[end]! : UNKNOWN);
      texels.push(tint.r, tint.g, tint.b, isKnown ? 0 : 1);
      normals.push(out[3 * i]!, out[3 * i + 1]!, out[3 * i + 2]!);
    }
  }
  return { count: normals.length / 3, texels: new Float32Array(texels), normals: new Float32Array(normals) };
}

/** How deep a place lies in the band of a piece, metres: 0 at its edge, negative outside; and the radius there. */
export function depthIn({ texels }: Pieces, piece: number, x: number, y: number, z: number): { depth: number; radius: number } {
  const at = 12 * piece;
  const [ax, ay, az] = [texels[at]!, texels[at + 1]!, texels[at + 2]!];
  const [bx, by, bz] = [texels[at + 4]! - ax, texels[at + 5]! - ay, texels[at + 6]! - az];
  const square = bx * bx + by * by + bz * bz;
  const along = square > 0 ? Math.min(1, Math.max(0, ((x - ax) * bx + (y - ay) * by + (z - az) * bz) / square)) : 0;
  const radius = texels[at + 3]! + along * (texels[at + 7]! - texels[at + 3]!);
  return { depth: radius - Math.hypot(x - ax - along * bx, y - ay - along * by, z - az - along * bz), radius };
}

/** The known radius where a place on the skin lies in a band, of the piece in which it lies deepest; null outside of all. */
export function radiusAt(pieces: Pieces, at: Vector3, normal: Vector3): number | null {
  let best = { depth: 0, radius: NaN };
  for (let piece = 0; piece < pieces.count; piece += 1) {
    if (pieces.texels[12 * piece + 11] === 1 || !isFacing(pieces, piece, normal)) continue;
    const found = depthIn(pieces, piece, at.x, at.y, at.z);
    if (found.depth > best.depth) best = found;
  }
  return Number.isNaN(best.radius) ? null : best.radius;
}

const isFacing = ({ normals }: Pieces, piece: number, { x, y, z }: Vector3): boolean => normals[3 * piece]! * x + normals[3 * piece + 1]! * y + normals[3 * piece + 2]! * z >= FACING;

/** Triangles of the skin near the pieces, by their number: the runs of pieces that they are near to. */
function nearTriangles(bvh: MeshBVH, pieces: Pieces): Map<number, number[]> {
  const found = new Map<number, number[]>();
  const box = new Box3();
  const end = new Vector3();
  for (let first = 0; first < pieces.count; first += RUN) {
    box.makeEmpty();
    let widest = 0;
    for (let row = 12 * first; row < 12 * Math.min(first + RUN, pieces.count); row += 4) {
      if (row % 12 === 8) continue; // colours
      box.expandByPoint(end.fromArray(pieces.texels, row));
      widest = Math.max(widest, pieces.texels[row + 3]!);
    }
    box.expandByScalar(widest);
    bvh.shapecast({
      intersectsBounds: (bounds) => bounds.intersectsBox(box),
      intersectsRange: (offset, count) => {
        for (let i = offset; i < offset + count; i += 1) {
          const triangle = bvh.resolveTriangleIndex(i);
          const runs = found.get(triangle);
          if (runs) runs.push(first);
          else found.set(triangle, [first]);
        }
        return false;
      },
    });
  }
  return found;
}

/** `skin` has an index and its BVH as `boundsTree`. */
export function patchOf(skin: BufferGeometry, pieces: Pieces): Patch {
  const position: number[] = [];
  const range: number[] = [];
  const entries: number[] = [];
  const places = skin.attributes.position!;
  const index = skin.index!;
  const corners = [new Vector3(), new Vector3(), new Vector3()] as const;
  const [middle, normal, side] = [new Vector3(), new Vector3(), new Vector3()];
  for (const [triangle, runs] of nearTriangles(skin.boundsTree as MeshBVH, pieces)) {
    corners.forEach((corner, k) => corner.fromBufferAttribute(places, index.getX(3 * triangle + k)));
    const [a, b, c] = corners;
    normal.subVectors(b, a).cross(side.subVectors(c, a)).normalize();
    middle.copy(a).add(b).add(c).divideScalar(3);
    const reach = STEEP * Math.max(a.distanceTo(middle), b.distanceTo(middle), c.distanceTo(middle));
    const near: [piece: number, depth: number][] = [];
    let deepest = -Infinity;
    for (const first of runs)
      for (let piece = first; piece < Math.min(first + RUN, pieces.count); piece += 1) {
        if (!isFacing(pieces, piece, normal)) continue;
        const { depth } = depthIn(pieces, piece, middle.x, middle.y, middle.z);
        if (depth + reach <= 0) continue;
        near.push([piece, depth]);
        deepest = Math.max(deepest, depth);
      }
    if (near.length === 0) continue;
    const isWithin = deepest - reach > EDGE; // all of it, by one piece alone
    const kept = near.filter(([, depth]) => (isWithin ? depth === deepest : depth + reach >= deepest - reach));
    for (const corner of corners) {
      position.push(corner.x, corner.y, corner.z);
      range.push(entries.length, isWithin ? 1 : kept.length);
    }
    entries.push(...(isWithin ? kept.slice(0, 1) : kept).map(([piece]) => piece));
  }
  return { position: new Float32Array(position), range: new Float32Array(range), entries: new Float32Array(entries) };
}
