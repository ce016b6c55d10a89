// Line segments as triangles, in the attributes that three.js's LineMaterial reads.  Its own LineSegmentsGeometry has one small
// shape drawn many times, which a browser without a graphics card begins anew for each segment: the thousand of a drawing
// then take longer than the body.  Here all segments are one drawing.
import { Box3, BufferAttribute, BufferGeometry, Sphere } from "three";

/** One segment: across (-1 to 1) and along (beyond the start, start, end, beyond the end) of its eight corners. */
const CORNERS = [-1, 2, 1, 2, -1, 1, 1, 1, -1, 0, 1, 0, -1, -1, 1, -1];
const ACROSS_AND_BEYOND = [-1, 2, 1, 2, -1, 1, 1, 1, -1, -1, 1, -1, -1, -2, 1, -2];
const TRIANGLES = [0, 2, 1, 2, 3, 1, 2, 4, 3, 4, 5, 3, 4, 6, 5, 6, 7, 5];
const EACH = CORNERS.length / 2;

/** Surfaces of the same segments, one for each way to colour them; whatever else they hold they share. */
export class LineTriangles<Way extends string> {
  readonly geometries: Readonly<Record<Way, BufferGeometry>>;
  private count = -1;

  constructor(
    private readonly ways: readonly Way[],
    private readonly isDashed: boolean,
  ) {
    this.geometries = Object.fromEntries(ways.map((way) => [way, new BufferGeometry()])) as Record<Way, BufferGeometry>;
  }

  /**
   * `ends`: both ends of each segment, x y z, metres; `colours`: red, green, blue at both ends of each segment, as many.
   * Buffers are reused while the number of segments stays, as it does from iteration to iteration.
   */
  set(ends: Float32Array, colours: Readonly<Record<Way, Float32Array>>): void {
    const count = ends.length / 6;
    if (count !== this.count) this.make(count);
    const { instanceStart, instanceEnd, instanceDistanceStart, instanceDistanceEnd } = this.geometries[this.ways[0]!].attributes;
    spread(instanceStart as BufferAttribute, ends, 0);
    spread(instanceEnd as BufferAttribute, ends, 3);
    if (this.isDashed) {
      const distances = distancesAlong(ends);
      spread(instanceDistanceStart as BufferAttribute, distances, 0);
      spread(instanceDistanceEnd as BufferAttribute, distances, 1);
    }
    const sphere = new Box3().setFromArray(ends).getBoundingSphere(new Sphere()); // by its middle three.js sorts what is translucent
    for (const way of this.ways) {
      spread(this.geometries[way].attributes.instanceColorStart as BufferAttribute, colours[way], 0);
      spread(this.geometries[way].attributes.instanceColorEnd as BufferAttribute, colours[way], 3);
      this.geometries[way].boundingSphere = sphere;
    }
  }

  private make(count: number): void {
    this.count = count;
    for (const way of this.ways) this.geometries[way].dispose(); // what is left is filled again, and sent anew
    const vertices = EACH * count;
    const repeated = (size: number, shape: readonly number[]): BufferAttribute => {
      const values = new Float32Array(size * vertices);
      for (let at = 0; at < values.length; at += shape.length) values.set(shape, at);
      return new BufferAttribute(values, size);
    };
    const empty = (size: number): BufferAttribute => new BufferAttribute(new Float32Array(size * vertices), size);
    const index = new Uint32Array(TRIANGLES.length * count);
    for (let i = 0; i < index.length; i += 1) index[i] = TRIANGLES[i % TRIANGLES.length]! + EACH * Math.floor(i / TRIANGLES.length);
    const shared: Record<string, BufferAttribute> = {
      position: repeated(2, CORNERS),
      uv: repeated(2, ACROSS_AND_BEYOND),
      instanceStart: empty(3),
      instanceEnd: empty(3),
      ...(this.isDashed ? { instanceDistanceStart: empty(1), instanceDistanceEnd: empty(1) } : {}),
    };
    const triangles = new BufferAttribute(index, 1);
    for (const way of this.ways) {
      const geometry = this.geometries[way].setIndex(triangles);
      for (const [name, attribute] of Object.entries(shared)) geometry.setAttribute(name, attribute);
      geometry.setAttribute("instanceColorStart", empty(3)).setAttribute("instanceColorEnd", empty(3));
    }
  }
}

/** Gives all corners of a segment its row of `from`, from place `start` on; there are two ends in a row. */
function spread(to: BufferAttribute, from: Float32Array, start: number): void {
  const { itemSize: size, array } = to;
  for (let i = 0; i < to.count; i += 1) {
    const row = 2 * size * Math.floor(i / EACH) + start;
    for (let k = 0; k < size; k += 1) array[size * i + k] = from[row + k]!;
  }
  to.needsUpdate = true;
}

/** Way along all segments, one after another, to both ends of each; metres. */
function distancesAlong(ends: Float32Array): Float32Array {
  const out = new Float32Array(ends.length / 3);
  for (let i = 0, way = 0; i < out.length; i += 2) {
    out[i] = way;
    way += Math.hypot(ends[3 * i + 3]! - ends[3 * i]!, ends[3 * i + 4]! - ends[3 * i + 1]!, ends[3 * i + 5]! - ends[3 * i + 2]!);
    out[i + 1] = way;
  }
  return out;
}
