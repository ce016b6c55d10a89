// Which triangles of a scan are the patient's skin: a table under the patient and loose pieces beside the body are not shown and
// not drawn on.
//
// The service says where the table is; the plane is laid once more through what lies near it and faces as it does.  Skin
// that rests on the table leaves it steeply, so close to the plane the direction decides.  What is left falls into
// connected pieces: those that are small beside the largest are scraps, and those that the service has cut away, of which
// it names a place on each, are other people's.  Positions are metres in the scan's own axes.
import type { Vector } from "../api/types";
import { cross, dot } from "../viewer/frame";

const WELD = 2e-5; // metres; textures split vertices that are one place, and 2 m in such steps still fit three to a number
const CELLS = 2 ** 17;
const PIECE_SHARE = 0.05; // of the largest piece's area; an arm or a breast scanned apart has more, a chair's edge less
const BIN = 0.01; // metres, of the heights among which the table is looked for
const TABLE_SHARE = 0.06; // of the area, as where the service proposes it
const FACING = Math.cos((20 * Math.PI) / 180); // of what the plane is laid through
const LIKE_TABLE = Math.cos((40 * Math.PI) / 180); // of what is cut: noise tilts small triangles
const BAND = { least: 0.006, most: 0.012, flat: 0.004 }; // metres: half the thickness of what is cut, and the spread that is no plane any more
const ROUNDS = 4; // of laying the plane through what lies near it; it rests after two or three

export interface Drawable {
  /** by triangle: 1 or 0 */
  readonly isSkin: Uint8Array;
  readonly count: number;
  /** by triangle: 1 where the normals of its piece point out of the body, -1 where they point into it */
  readonly outwards: Int8Array;
}

/** As the service found it. */
export interface TablePlane {
  readonly normal: Vector; // unit, from the table to the body that lies on it
  readonly height: number | null; // metres along it; null: not known, and looked for
}

interface Triangles {
  readonly corners: Int32Array; // 3 for each; places, so that what touches shares them
  readonly places: number;
  readonly crosses: Float64Array; // 3 for each: normal, as long as twice the area
  readonly centres: Float64Array;
  readonly areas: Float64Array;
}

/** Vertices at one place become one. */
function welded(positions: ArrayLike<number>): { placeOf: Int32Array; places: number } {
  let [x, y, z] = [Infinity, Infinity, Infinity];
  for (let i = 0; i < positions.length; i += 3) {
    x = Math.min(x, positions[i]!);
    y = Math.min(y, positions[i + 1]!);
    z = Math.min(z, positions[i + 2]!);
  }
  const known = new Map<number, number>();
  const placeOf = new Int32Array(positions.length / 3);
  for (let i = 0; i < positions.length; i += 3) {
    const key = (Math.round((positions[i]! - x) / WELD) * CELLS + Math.round((positions[i + 1]! - y) / WELD)) * CELLS + Math.round((positions[i + 2]! - z) / WELD);
    let place = known.get(key);
    if (place === undefined) known.set(key, (place = known.size));
    placeOf[i / 3] = place;
  }
  return { placeOf, places: known.size };
}

// Plain numbers in the loops over all triangles: a scan has some hundred thousand of them.
function trianglesOf(positions: ArrayLike<number>, index: ArrayLike<number>): Triangles {
  const { placeOf, places } = welded(positions);
  const [corners, crosses, centres, areas] = [new Int32Array(index.length), new Float64Array(index.length), new Float64Array(index.length), new Float64Array(index.length / 3)];
  for (let i = 0; i < index.length; i += 3) {
    const [a, b, c] = [3 * index[i]!, 3 * index[i + 1]!, 3 * index[i + 2]!];
    const [ax, ay, az] = [positions[a]!, positions[a + 1]!, positions[a + 2]!];
    const [ux, uy, uz] = [positions[b]! - ax, positions[b + 1]! - ay, positions[b + 2]! - az];
    const [vx, vy, vz] = [positions[c]! - ax, positions[c + 1]! - ay, positions[c + 2]! - az];
    const [x, y, z] = [uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx];
    crosses[i] = x;
    crosses[i + 1] = y;
    crosses[i + 2] = z;
    centres[i] = ax + (ux + vx) / 3;
    centres[i + 1] = ay + (uy + vy) / 3;
    centres[i + 2] = az + (uz + vz) / 3;
    areas[i / 3] = Math.hypot(x, y, z) / 2;
    for (let k = 0; k < 3; k += 1) corners[i + k] = placeOf[index[i + k]!]!;
  }
  return { corners, places, crosses, centres, areas };
}

/** How far each of these points, or vectors, goes along a direction. */
function along(points: ArrayLike<number>, [x, y, z]: Vector): Float64Array {
  const out = new Float64Array(points.length / 3);
  for (let i = 0; i < out.length; i += 1) out[i] = points[3 * i]! * x + points[3 * i + 1]! * y + points[3 * i + 2]! * z;
  return out;
}

/** The height (m) at which two neighbouring bins hold the most area; null where that is no table. */
function levelOf(heights: Float64Array, facing: Uint8Array, areas: Float64Array): number | null {
  const bins = new Map<number, number>();
  let total = 0;
  for (let face = 0; face < areas.length; face += 1) {
    total += areas[face]!;
    if (!facing[face]) continue;
    const bin = Math.floor(heights[face]! / BIN);
    bins.set(bin, (bins.get(bin) ?? 0) + areas[face]!);
  }
  let best = { bin: 0, area: 0 };
  for (const [bin, area] of bins) {
    const both = area + (bins.get(bin + 1) ?? 0);
    if (both > best.area) best = { bin, area: both };
  }
  return best.area >= TABLE_SHARE * total ? (best.bin + 1) * BIN : null;
}

/** The plane p u + q v + r, as (p, q, r), through heights h at (u, v) with weights w, by least squares; null: they lie on a line. */
function planeThrough(rows: readonly number[], at: { u: Float64Array; v: Float64Array; h: Float64Array; w: Float64Array }): Vector | null {
  let [uu, uv, u1, vv, v1, one, uh, vh, h1] = [0, 0, 0, 0, 0, 0, 0, 0, 0];
  for (const row of rows) {
    const [u, v, h, w] = [at.u[row]!, at.v[row]!, at.h[row]!, at.w[row]!];
    uu += w * u * u;
    uv += w * u * v;
    u1 += w * u;
    vv += w * v * v;
    v1 += w * v;
    one += w;
    uh += w * u * h;
    vh += w * v * h;
    h1 += w * h;
  }
  const [p, q, r, h]: Vector[] = [[uu, uv, u1], [uv, vv, v1], [u1, v1, one], [uh, vh, h1]];
  const whole = dot(p!, cross(q!, r!));
  return Math.abs(whole) < 1e-18 ? null : [dot(h!, cross(q!, r!)) / whole, dot(p!, cross(h!, r!)) / whole, dot(p!, cross(q!, h!)) / whole];
}

interface Table {
  readonly isTable: Uint8Array; // by triangle
  readonly heights: Float64Array; // of triangles above the plane, metres
  readonly band: number;
}

/** null when nothing flat is there. */
function tableOf({ crosses, centres, areas, corners, places }: Triangles, positions: ArrayLike<number>, index: ArrayLike<number>, { normal, height }: TablePlane): Table | null {
  const across = cross(normal, Math.abs(normal[0]) < 0.8 ? [1, 0, 0] : [0, 1, 0]);
  const axis = across.map((value) => value / Math.hypot(...across)) as Vector;
  const other = cross(normal, axis);
  const at = { u: along(centres, axis), v: along(centres, other), h: along(centres, normal), w: areas };
  const facing = Uint8Array.from(along(crosses, normal), (value, face) => (value > FACING * 2 * areas[face]! ? 1 : 0));
  const level = height ?? levelOf(at.h, facing, areas);
  if (level === null) return null;
  let [plane, band, spread]: [Vector, number, number] = [[0, 0, level], 2 * BIN, Infinity];
  const above = (face: number): number => at.h[face]! - plane[0] * at.u[face]! - plane[1] * at.v[face]! - plane[2];
  for (let round = 0; round < ROUNDS; round += 1) {
    const rows: number[] = [];
    for (let face = 0; face < areas.length; face += 1) if (facing[face] && Math.abs(above(face)) < band) rows.push(face);
    const laid = planeThrough(rows, at);
    if (!laid) return null;
    plane = laid;
    let [weight, squares] = [0, 0];
    for (const face of rows) {
      weight += areas[face]!;
      squares += areas[face]! * above(face) ** 2;
    }
    spread = Math.sqrt(squares / weight);
    band = Math.min(2 * BIN, Math.max(BAND.least, 4 * spread));
  }
  if (spread > BAND.flat) return null;
  band = Math.min(BAND.most, band);
  const [u, v, h] = [along(positions, axis), along(positions, other), along(positions, normal)];
  const isNear = (vertex: number): boolean => Math.abs(h[vertex]! - plane[0] * u[vertex]! - plane[1] * v[vertex]! - plane[2]) < band;
  const around = new Float64Array(3 * places); // of all triangles at a place: single ones are noisy
  for (let i = 0; i < corners.length; i += 1) for (let k = 0; k < 3; k += 1) around[3 * corners[i]! + k]! += crosses[i - (i % 3) + k]!;
  const looks = along(around, normal).map((value, place) => value / Math.max(Math.hypot(around[3 * place]!, around[3 * place + 1]!, around[3 * place + 2]!), 1e-12));
  const isTable = Uint8Array.from(areas, (_, face) => {
    const isFlat = isNear(index[3 * face]!) && isNear(index[3 * face + 1]!) && isNear(index[3 * face + 2]!);
    return isFlat && (looks[corners[3 * face]!]! + looks[corners[3 * face + 1]!]! + looks[corners[3 * face + 2]!]!) / 3 > LIKE_TABLE ? 1 : 0;
  });
  return { isTable, heights: Float64Array.from(areas, (_, face) => above(face)), band };
}

/** The triangle whose middle is nearest to a place. */
function nearestFace(centres: Float64Array, [x, y, z]: Vector): number {
  let [best, least] = [0, Infinity];
  for (let i = 0; i < centres.length; i += 3) {
    const away = (centres[i]! - x) ** 2 + (centres[i + 1]! - y) ** 2 + (centres[i + 2]! - z) ** 2;
    if (away < least) [best, least] = [i / 3, away];
  }
  return best;
}

/** `plane`: null where the service found no table; `others`: a place on each piece that is another person's. */
export function drawableOf(positions: ArrayLike<number>, index: ArrayLike<number>, plane: TablePlane | null, others: readonly Vector[] = []): Drawable {
  const triangles = trianglesOf(positions, index);
  const { corners, places, areas, crosses, centres } = triangles;
  const table = plane && tableOf(triangles, positions, index, plane);
  const parent = Int32Array.from({ length: places }, (_, i) => i);
  const rootOf = (place: number): number => {
    let root = place;
    while (parent[root] !== root) root = parent[root] = parent[parent[root]!]!;
    return root;
  };
  for (let face = 0; face < areas.length; face += 1) {
    if (table?.isTable[face]) continue;
    const root = rootOf(corners[3 * face]!);
    parent[rootOf(corners[3 * face + 1]!)] = root;
    parent[rootOf(corners[3 * face + 2]!)] = rootOf(root);
  }
  const pieces = new Map<number, { area: number; top: number }>();
  for (let face = 0; face < areas.length; face += 1) {
    if (table?.isTable[face]) continue;
    const root = rootOf(corners[3 * face]!);
    const piece = pieces.get(root) ?? { area: 0, top: -Infinity };
    piece.area += areas[face]!;
    if (table) piece.top = Math.max(piece.top, table.heights[face]!);
    pieces.set(root, piece);
  }
  const isLow = ({ top }: { top: number }): boolean => table !== null && top < table.band; // the table's edge, the floor
  const largest = Math.max(0, ...[...pieces.values()].filter((piece) => !isLow(piece)).map(({ area }) => area));
  for (const place of areas.length === 0 ? [] : others) {
    const root = rootOf(corners[3 * nearestFace(centres, place)]!);
    if (pieces.get(root)?.area !== largest) pieces.delete(root); // a piece joined to the body by a rest of the table stays
  }
  const isSkin = Uint8Array.from(areas, (_, face) => {
    const piece = table?.isTable[face] ? undefined : pieces.get(rootOf(corners[3 * face]!));
    return piece !== undefined && !isLow(piece) && piece.area >= PIECE_SHARE * largest ? 1 : 0;
  });
  let [count, total] = [0, 0];
  const middle: Vector = [0, 0, 0];
  isSkin.forEach((is, face) => {
    if (!is) return;
    count += 1;
    total += areas[face]!;
    for (let k = 0; k < 3; k += 1) middle[k]! += areas[face]! * centres[3 * face + k]!;
  });
  for (let k = 0; k < 3; k += 1) middle[k]! /= Math.max(total, 1e-12);
  const out = new Map<number, number>(); // by piece
  isSkin.forEach((is, face) => {
    const piece = rootOf(corners[3 * face]!);
    let sum = out.get(piece) ?? 0;
    for (let k = 0; is && k < 3; k += 1) sum += crosses[3 * face + k]! * (centres[3 * face + k]! - middle[k]!);
    out.set(piece, sum);
  });
  return { isSkin, count, outwards: Int8Array.from(isSkin, (_, face) => ((out.get(rootOf(corners[3 * face]!)) ?? 0) < 0 ? -1 : 1)) };
}
