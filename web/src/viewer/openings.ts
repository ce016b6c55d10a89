// The model's openings (neck, arms, waist) closed for looking, so that its ends read as cuts through a body and not as the
// inside of a shell.  The triangles use the rims' own vertices, so they follow pose and shape; they stand after the
// surface's own and are drawn where the model stands alone, not over a scan.
import { type BufferAttribute, type BufferGeometry, type Color, DoubleSide, MeshLambertMaterial, Triangle } from "three";

const SHADE = 0.86; // of the surface's colour

/** Vertices around each opening, in the order in which the surface's border runs. */
export function rims(triangles: ArrayLike<number>): number[][] {
  const next = new Map<number, number>();
  const edges = new Set<string>();
  for (let i = 0; i < triangles.length; i += 1) edges.add(`${triangles[i]} ${triangles[i - (i % 3) + ((i + 1) % 3)]}`);
  for (const edge of edges) {
    const [a, b] = edge.split(" ").map(Number) as [number, number];
    if (!edges.has(`${b} ${a}`)) next.set(a, b);
  }
  const found: number[][] = [];
  for (const start of next.keys()) {
    const rim: number[] = [];
    for (let at: number | undefined = start; at !== undefined && next.has(at); ) {
      rim.push(at);
      const after: number | undefined = next.get(at);
      next.delete(at);
      at = after;
    }
    if (rim.length > 2) found.push(rim);
  }
  return found;
}

/** A strip of triangles across a rim from one of its places to the opposite one, facing away from the surface. */
function strip(rim: readonly number[], start: number): number[] {
  const at = (k: number): number => rim[(start + k + rim.length) % rim.length]!;
  const found: number[] = [];
  for (let up = 0, down = -1; up - down < rim.length - 1; ) {
    if (up < -down) found.push(at(up), at(down), at(++up));
    else found.push(at(up), at(down), at(--down));
  }
  return found;
}

/** m², of triangles. */
function area(triangles: readonly number[], positions: BufferAttribute): number {
  const one = new Triangle();
  let sum = 0;
  for (let i = 0; i < triangles.length; i += 3) sum += one.setFromAttributeAndIndices(positions, triangles[i]!, triangles[i + 1]!, triangles[i + 2]!).getArea();
  return sum;
}

/** Triangles (vertices, three in a row) over a rim: of all strips the flattest. */
function lid(rim: readonly number[], positions: BufferAttribute): number[] {
  const strips = rim.map((_, start) => strip(rim, start));
  const areas = strips.map((each) => area(each, positions));
  return strips[areas.indexOf(Math.min(...areas))]!;
}

/** The geometry with its lids as a second group of triangles; `show` says whether they are drawn. */
export function withLids(geometry: BufferGeometry): { show: (shown: boolean) => void } {
  const own = geometry.index!;
  const lids = rims(own.array).flatMap((rim) => lid(rim, geometry.attributes.position as BufferAttribute));
  geometry.setIndex([...own.array, ...lids]);
  geometry.addGroup(0, own.count, 0);
  geometry.addGroup(own.count, lids.length, 1);
  const show = (shown: boolean): void => geometry.setDrawRange(0, shown ? own.count + lids.length : own.count);
  show(false);
  return { show };
}

/** Of the lids: flat, whatever the skin's normals at the rim say. */
export const lidMaterial = (): MeshLambertMaterial => new MeshLambertMaterial({ side: DoubleSide, flatShading: true });

export const tintLid = (material: MeshLambertMaterial, surface: Color): void => void material.color.copy(surface).multiplyScalar(SHADE);
