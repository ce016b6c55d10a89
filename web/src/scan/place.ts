// Puts a mesh where its file says.  The service's own files only move and size it: then there is nothing to turn,
// and of the half million vertices of a large scan only the places change; three.js's applyMatrix4 would turn their normals as well and
// look for its bounds again, which takes longer than a picture may.
import { BufferAttribute, type BufferGeometry, type Matrix4 } from "three";

/** As `applyMatrix4`. */
export function place(geometry: BufferGeometry, matrix: Matrix4): void {
  const [a, b, c, d, e, f, g, h, i, j, k, l, x, y, z, w] = matrix.elements;
  const isMove = a > 0 && a === f && a === k && w === 1 && [b, c, d, e, g, h, i, j, l].every((value) => value === 0);
  const { position } = geometry.attributes;
  if (!isMove || !(position instanceof BufferAttribute && position.array instanceof Float32Array)) {
    geometry.applyMatrix4(matrix);
    return;
  }
  const { array } = position;
  for (let at = 0; at < array.length; at += 3) {
    array[at] = a * array[at]! + x;
    array[at + 1] = a * array[at + 1]! + y;
    array[at + 2] = a * array[at + 2]! + z;
  }
  position.needsUpdate = true;
  for (const bounds of [geometry.boundingBox, geometry.boundingSphere]) bounds?.applyMatrix4(matrix);
}
