import { BufferAttribute, BufferGeometry, DoubleSide, Group, Mesh, MeshBasicMaterial, PerspectiveCamera, Vector3 } from "three";
import { acceleratedRaycast, MeshBVH } from "three-mesh-bvh";
import { expect, test } from "vitest";
import { isHidden } from "../../src/viewer/picking";

test("a point behind the scan is hidden as soon as the scan has its tree; until then no triangle is looked at", () => {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(new Float32Array([-1, -1, 0, 1, -1, 0, 0, 1, 0]), 3)).setIndex([0, 1, 2]);
  const mesh = new Mesh(geometry, new MeshBasicMaterial({ side: DoubleSide }));
  let looks = 0;
  mesh.raycast = (...given) => {
    looks += 1;
    acceleratedRaycast.apply(mesh, given);
  };
  const camera = new PerspectiveCamera();
  camera.position.set(0, 0, 2);
  const [viewer, scan] = [{ body: new Group(), camera }, { mesh, normalAt: () => null }];
  const behind = new Vector3(0, 0, -0.5);
  expect(isHidden(viewer, scan, behind, null)).toBe(false);
  expect(looks).toBe(0);
  geometry.boundsTree = new MeshBVH(geometry, { indirect: true });
  expect(isHidden(viewer, scan, behind, null)).toBe(true);
  expect(isHidden(viewer, scan, new Vector3(0, 0, 0.5), null)).toBe(false);
  expect(looks).toBe(2);
});
