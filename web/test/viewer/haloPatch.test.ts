import { BufferAttribute, BufferGeometry, Color, Vector3 } from "three";
import { MeshBVH } from "three-mesh-bvh";
import { describe, expect, it } from "vitest";
import { type Banded, depthIn, patchOf, piecesOf, radiusAt } from "../../src/viewer/lines/haloPatch";

const CELL = 0.005;

/** A flat square of skin of 0.1 m, facing +z or away from it. */
function plate(facing = 1): BufferGeometry {
  const side = 21;
  const position = Array.from({ length: side * side }, (_, i) => [CELL * (i % side) - 0.05, CELL * Math.floor(i / side) - 0.05, 0]).flat();
  const index: number[] = [];
  for (let j = 0; j + 1 < side; j += 1)
    for (let i = 0; i + 1 < side; i += 1) {
      const at = j * side + i;
      for (const triangle of [[at, at + 1, at + side], [at + 1, at + side + 1, at + side]]) index.push(...(facing > 0 ? triangle : triangle.reverse()));
    }
  const geometry = new BufferGeometry().setAttribute("position", new BufferAttribute(Float32Array.from(position), 3));
  geometry.setIndex(index);
  geometry.boundsTree = new MeshBVH(geometry, { indirect: true });
  return geometry;
}

/** A line along x through the middle, whose radius grows from 3 to 13 mm. */
function line(radius: (share: number) => number = (share) => 0.003 + 0.01 * share): Banded {
  const count = 41;
  const all = Array.from({ length: count }, (_, i) => i / (count - 1));
  return { points: Float32Array.from(all.flatMap((share) => [0.08 * share - 0.04, 0, 0])), normals: Float32Array.from(all.flatMap(() => [0, 0, 1])), radii: Float32Array.from(all, radius), isClosed: false, tint: new Color(0) };
}

/** As the pixels of the patch find it: how deep each corner lies by the pieces of its triangle; all of the skin that has none is outside. */
function depthsOf(lines: readonly Banded[], skin = plate()): { x: number; y: number; depth: number }[] {
  const pieces = piecesOf(lines);
  const { position, range, entries } = patchOf(skin, pieces);
  return Array.from({ length: range.length / 2 }, (_, corner) => {
    const [x, y, z] = [0, 1, 2].map((k) => position[3 * corner + k]!) as [number, number, number];
    const of = entries.subarray(range[2 * corner], range[2 * corner]! + range[2 * corner + 1]!);
    return { x, y, depth: Math.max(...[...of].map((piece) => depthIn(pieces, piece, x, y, z).depth)) };
  });
}

describe("the halo of a line", () => {
  it("is at every place as wide as the radius there, whichever few pieces a triangle keeps", () => {
    const all = piecesOf([line()]);
    const seen = depthsOf([line()]);
    for (const { x, y, depth } of seen) {
      const whole = Math.max(...Array.from({ length: all.count }, (_, piece) => depthIn(all, piece, x, y, 0).depth));
      expect(Math.abs(depth - whole) < 1e-6 || Math.max(depth, whole) < 0 || Math.min(depth, whole) > 0.001, "the same, or both outside, or both well inside").toBe(true);
    }
    const widest = (at: number): number => Math.max(...seen.filter(({ x, depth }) => Math.abs(x - at) < 1e-6 && depth > 0).map(({ y }) => Math.abs(y)));
    expect([widest(-0.035), widest(0.035)]).toEqual([0, expect.closeTo(0.01, 6)]); // of a grid of 5 mm: 3.6 and 12.4 mm
  });

  it("has every triangle that its edge runs through, and each once", () => {
    const skin = plate();
    const { position } = patchOf(skin, piecesOf([line(() => 0.001)])); // narrower than a triangle
    const middles = new Set<string>();
    for (let i = 0; i < position.length; i += 9) middles.add([0, 1].map((k) => Math.round(1e6 * (position[i + k]! + position[i + 3 + k]! + position[i + 6 + k]!))).join());
    expect(middles.size).toBe(position.length / 9);
    expect(middles.size).toBeGreaterThanOrEqual(2 * 16); // both sides of the grid's row that it runs along
  });

  it("does not reach over to skin that faces another way", () => {
    expect(depthsOf([line()], plate(-1))).toHaveLength(0);
  });

  it("is as wide as a finger, and marked, where no radius is known", () => {
    const { count, texels } = piecesOf([line((share) => (share > 0.5 ? NaN : 0.003))]);
    const rows = Array.from({ length: count }, (_, piece) => [texels[12 * piece + 3], texels[12 * piece + 11]]);
    expect(rows[0]).toEqual([expect.closeTo(0.003, 6), 0]);
    expect(rows.at(-1)).toEqual([expect.closeTo(0.01, 6), 1]);
  });

  it("says the radius where a place lies in it, and of a single point around it", () => {
    const up = new Vector3(0, 0, 1);
    const pieces = piecesOf([line()]);
    expect(radiusAt(pieces, new Vector3(0.039, 0.006, 0), up)).toBeCloseTo(0.0129, 3);
    expect(radiusAt(pieces, new Vector3(-0.04, 0.006, 0), up)).toBeNull();
    expect(radiusAt(pieces, new Vector3(0.039, 0.006, 0), up.clone().negate())).toBeNull();
    const point = piecesOf([{ ...line(), points: new Float32Array([0, 0, 0]), normals: new Float32Array([0, 0, 1]), radii: new Float32Array([0.004]) }]);
    expect(radiusAt(point, new Vector3(0.003, 0, 0), up)).toBeCloseTo(0.004, 6);
    expect(radiusAt(point, new Vector3(0.005, 0, 0), up)).toBeNull();
  });
});
