import { BufferAttribute, BufferGeometry, Euler, Matrix4 } from "three";
import { expect, test } from "vitest";
import { place } from "../../src/scan/place";
import { seeded } from "../seeded";

function cloud(): BufferGeometry {
  const random = seeded(7);
  const values = (): Float32Array => Float32Array.from({ length: 60 }, () => random() - 0.5);
  const made = new BufferGeometry().setAttribute("position", new BufferAttribute(values(), 3)).setAttribute("normal", new BufferAttribute(values(), 3));
  made.normalizeNormals();
  made.computeBoundingBox();
  made.computeBoundingSphere();
  return made;
}

test.each([
  ["moved", new Matrix4().makeTranslation(0.1, -1.7, 3)],
  ["turned and moved", new Matrix4().makeRotationFromEuler(new Euler(0.3, 1, -2)).setPosition(1, 2, 3)],
  ["scaled", new Matrix4().makeScale(2, 2, 2)],
  ["left", new Matrix4()],
])("%s: every vertex is where applyMatrix4 has it, to the last bit, and normals and bounds as far as numbers go", (_name, matrix) => {
  const [found, wanted] = [cloud(), cloud().applyMatrix4(matrix)];
  place(found, matrix);
  expect(found.attributes.position!.array).toEqual(wanted.attributes.position!.array);
  found.attributes.normal!.array.forEach((value, i) => expect(value).toBeCloseTo(wanted.attributes.normal!.array[i]!, 6));
  expect(found.boundingBox!.min.distanceTo(wanted.boundingBox!.min)).toBeLessThan(1e-6);
  expect(found.boundingBox!.max.distanceTo(wanted.boundingBox!.max)).toBeLessThan(1e-6);
  expect(found.boundingSphere!.center.distanceTo(wanted.boundingSphere!.center)).toBeLessThan(1e-6);
  expect(found.boundingSphere!.radius).toBeCloseTo(wanted.boundingSphere!.radius, 6);
});

test("a mesh that is only moved keeps its normals as they are: nobody writes them again", () => {
  const geometry = cloud();
  const before = geometry.attributes.normal!.array.slice();
  const version = (geometry.attributes.normal as BufferAttribute).version;
  place(geometry, new Matrix4().makeTranslation(1, 2, 3));
  expect(geometry.attributes.normal!.array).toEqual(before);
  expect((geometry.attributes.normal as BufferAttribute).version).toBe(version);
});
