// The triangles of lines are those of three.js's own lines, whose instances are drawn one by one.
import { type BufferGeometry, InstancedBufferGeometry } from "three";
import { LineMaterial } from "three/addons/lines/LineMaterial.js";
import { LineSegments2 } from "three/addons/lines/LineSegments2.js";
import { LineSegmentsGeometry } from "three/addons/lines/LineSegmentsGeometry.js";
import { expect, test } from "vitest";
import { LineTriangles } from "../../src/viewer/lines/lineTriangles";
import { seeded } from "../seeded";

const NAMES = ["position", "uv", "instanceStart", "instanceEnd", "instanceColorStart", "instanceColorEnd", "instanceDistanceStart", "instanceDistanceEnd"];
const SHARED = ["position", "uv", "instanceStart", "instanceEnd", "instanceDistanceStart", "instanceDistanceEnd"];

/** What the shader is given for each corner of each triangle, one row each. */
function cornersOf(geometry: BufferGeometry): number[][] {
  const isInstanced = geometry instanceof InstancedBufferGeometry;
  const instances = isInstanced ? geometry.instanceCount : 1;
  const rows = [];
  for (let instance = 0; instance < instances; instance += 1) {
    for (const vertex of geometry.index!.array) {
      rows.push(
        NAMES.flatMap((name) => {
          const attribute = geometry.attributes[name]!;
          const at = isInstanced && name.startsWith("instance") ? instance : vertex;
          return Array.from({ length: name === "position" ? 2 : attribute.itemSize }, (_, k) => attribute.getComponent(at, k));
        }),
      );
    }
  }
  return rows;
}

test("the shader is given what three.js's instances give it, also after other lines and another number of them", () => {
  const random = seeded(4);
  const triangles = new LineTriangles(["ink", "outline"], true);
  for (const count of [7, 7, 3]) {
    const values = (): Float32Array => Float32Array.from({ length: 6 * count }, () => random());
    const [ends, ink, outline] = [values(), values(), values()];
    triangles.set(ends, { ink, outline });
    for (const [way, colours] of Object.entries({ ink, outline })) {
      const its = new LineSegmentsGeometry().setPositions(ends.slice()).setColors(colours.slice());
      new LineSegments2(its, new LineMaterial()).computeLineDistances();
      const ours = triangles.geometries[way as "ink" | "outline"];
      const [found, wanted] = [cornersOf(ours), cornersOf(its)];
      expect(found).toHaveLength(wanted.length);
      found.forEach((row, i) => row.forEach((value, k) => expect(value).toBeCloseTo(wanted[i]![k]!, 5)));
      expect(ours.boundingSphere!.center.distanceTo(its.boundingSphere!.center)).toBeLessThan(1e-6);
    }
    for (const name of SHARED) expect(triangles.geometries.ink.attributes[name], name).toBe(triangles.geometries.outline.attributes[name]);
  }
});

test("buffers stay while the number of segments does, and are let go when it changes", () => {
  const triangles = new LineTriangles(["ink"], false);
  const set = (count: number): void => triangles.set(new Float32Array(6 * count), { ink: new Float32Array(6 * count) });
  let disposed = 0;
  triangles.geometries.ink.addEventListener("dispose", () => (disposed += 1));
  set(2);
  const { instanceStart } = triangles.geometries.ink.attributes;
  const before = disposed;
  set(2);
  expect(triangles.geometries.ink.attributes.instanceStart).toBe(instanceStart);
  expect((instanceStart as { version: number }).version).toBe(2);
  expect(disposed).toBe(before);
  set(3);
  expect(triangles.geometries.ink.attributes.instanceStart).not.toBe(instanceStart);
  expect(disposed).toBe(before + 1);
});
