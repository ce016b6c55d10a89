import { BufferAttribute, BufferGeometry, Triangle } from "three";
import { expect, test } from "vitest";
import { rims, withLids } from "../../src/viewer/openings";

const SIDES = 7;

/** A tube of SIDES sides, open at both ends: ends 0 … 6 below and 7 … 13 above, counter-clockwise from outside. */
function tube(): BufferGeometry {
  const circle = Array.from({ length: SIDES }, (_, k) => [Math.cos((2 * Math.PI * k) / SIDES), Math.sin((2 * Math.PI * k) / SIDES)] as const);
  const places = [0, 3].flatMap((z) => circle.flatMap(([x, y]) => [x, y, z]));
  const index = circle.flatMap((_, k) => {
    const [a, b] = [k, (k + 1) % SIDES];
    return [a, b, b + SIDES, a, b + SIDES, a + SIDES];
  });
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(new Float32Array(places), 3));
  geometry.setIndex(index);
  return geometry;
}

const edgesOf = (index: ArrayLike<number>): string[] => Array.from(index, (vertex, i) => `${vertex} ${index[i - (i % 3) + ((i + 1) % 3)]}`);

test("every opening has one rim, and a closed surface has none", () => {
  const found = rims(tube().index!.array).map((rim) => rim.toSorted((a, b) => a - b));
  expect(found.toSorted((a, b) => a[0]! - b[0]!)).toEqual([[0, 1, 2, 3, 4, 5, 6], [7, 8, 9, 10, 11, 12, 13]]);
  expect(rims([0, 1, 2, 0, 2, 3, 0, 3, 1, 1, 3, 2])).toEqual([]);
});

test("with its lids the surface is closed and faces one way; they are flat, and drawn on demand", () => {
  const geometry = tube();
  const own = geometry.index!.count;
  const { show } = withLids(geometry);
  const edges = edgesOf(geometry.index!.array);
  expect(new Set(edges).size).toBe(edges.length);
  expect(edges.filter((edge) => !edges.includes(edge.split(" ").toReversed().join(" ")))).toEqual([]);
  expect(geometry.groups).toEqual([{ start: 0, count: own, materialIndex: 0 }, { start: own, count: 2 * 3 * (SIDES - 2), materialIndex: 1 }]);

  const one = new Triangle();
  let area = 0;
  for (let i = own; i < geometry.index!.count; i += 3) area += one.setFromAttributeAndIndices(geometry.attributes.position!, geometry.index!.getX(i), geometry.index!.getX(i + 1), geometry.index!.getX(i + 2)).getArea();
  expect(area).toBeCloseTo(SIDES * Math.sin((2 * Math.PI) / SIDES), 5); // both, each half of it

  expect(geometry.drawRange).toMatchObject({ start: 0, count: own });
  show(true);
  expect(geometry.drawRange.count).toBe(geometry.index!.count);
});

test("a surface without openings keeps its triangles", () => {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(new Float32Array([0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1]), 3));
  geometry.setIndex([0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3]);
  withLids(geometry).show(true);
  expect(geometry.index!.count).toBe(12);
});
