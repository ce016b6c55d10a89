import { BufferAttribute, BufferGeometry, DoubleSide, Matrix4, Mesh, MeshBasicMaterial, Raycaster, Vector3 } from "three";
import { acceleratedRaycast, MeshBVH } from "three-mesh-bvh";
import { expect, test } from "vitest";
import { extent } from "../../src/viewer/extent";
import { segments } from "../../src/viewer/lines/FatLines";
import { surfacePosition } from "../../src/viewer/lines/surfacePoints";
import { viewFromScan } from "../../src/viewer/Viewer";

// Two triangles that make the unit square in the plane z = 2.
const corners = [0, 0, 2, 1, 0, 2, 1, 1, 2, 0, 1, 2];
const square = [0, 1, 2, 0, 2, 3];

function mesh(): Mesh {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(new Float32Array(corners), 3));
  geometry.setIndex(square);
  geometry.boundsTree = new MeshBVH(geometry, { indirect: true });
  const made = new Mesh(geometry, new MeshBasicMaterial({ side: DoubleSide }));
  made.raycast = acceleratedRaycast;
  return made;
}

test("a ray meets the triangle that it should, and the order of the triangles stays", () => {
  const target = mesh();
  const ray = new Raycaster(new Vector3(0.25, 0.75, 10), new Vector3(0, 0, -1));
  ray.firstHitOnly = true;
  const [hit] = ray.intersectObject(target);
  expect(hit?.faceIndex).toBe(1);
  expect(hit?.point.toArray()).toEqual([0.25, 0.75, 2]);
  expect([...target.geometry.index!.array]).toEqual(square);
  ray.set(new Vector3(2, 2, 10), new Vector3(0, 0, -1));
  expect(ray.intersectObject(target)).toEqual([]);
});

test("a surface point follows its triangle wherever that goes, and knows which way is out", () => {
  const position = new Vector3();
  const normal = new Vector3();
  const at = (shift: number) => (vertex: number, target: Vector3) => target.fromArray(corners, 3 * vertex).addScalar(shift);
  surfacePosition({ face: 0, barycentric: [0.5, 0.25, 0.25] }, square, at(0), position, normal);
  expect(position.toArray()).toEqual([0.5, 0.25, 2]);
  expect(normal.toArray()).toEqual([0, 0, 1]);
  surfacePosition({ face: 0, barycentric: [0.5, 0.25, 0.25] }, square, at(3), position, normal);
  expect(position.toArray()).toEqual([3.5, 3.25, 5]);
});

test("a surface point on a triangle that is not there is an error and not a wrong place", () => {
  const at = (_: number, target: Vector3) => target;
  expect(() => surfacePosition({ face: 2, barycentric: [1, 0, 0] }, square, at, new Vector3(), new Vector3())).toThrow("no triangle 2");
});

test("a frame turns head to +Y, front to +Z and the patient's left to +X", () => {
  const turn = viewFromScan({ up: [0, 0, 1], front: [0, -1, 0] });
  const seen = (v: [number, number, number]) => new Vector3(...v).applyMatrix4(turn).toArray().map((x) => Math.round(x) + 0);
  expect(seen([0, 0, 1])).toEqual([0, 1, 0]);
  expect(seen([0, -1, 0])).toEqual([0, 0, 1]);
  expect(seen([1, 0, 0])).toEqual([1, 0, 0]);
});

test("a few stray points do not blow up the body's size", () => {
  const positions: number[] = [];
  for (let i = 0; i < 1000; i += 1) positions.push(i / 999, 0, 0);
  positions.push(50, 0, 0);
  const box = extent(positions, new Matrix4());
  expect(box.max.x).toBeLessThan(1.01);
});

test("a closed line comes back to its start, and bridged parts are kept apart", () => {
  const points = new Float32Array([0, 0, 0, 1, 0, 0, 1, 1, 0]);
  expect(segments([{ points, isClosed: true, bridged: null }], false).length).toBe(3 * 6);
  expect(segments([{ points, isClosed: false, bridged: null }], false).length).toBe(2 * 6);
  const line = { points, isClosed: false, bridged: [false, false, true] };
  expect([...segments([line], false)]).toEqual([0, 0, 0, 1, 0, 0]);
  expect([...segments([line], true)]).toEqual([1, 0, 0, 1, 1, 0]);
});
