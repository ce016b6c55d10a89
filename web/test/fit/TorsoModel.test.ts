// A rig by dual quaternions stands on the page where the service poses it: web/test/fit/dual_quaternions.json, written and
// checked by tests/gltf/test_page_skinning.py.
import { Group, Mesh, Vector3 } from "three";
import { expect, test } from "vitest";
import type { Model } from "../../src/api/types";
import { TorsoModel } from "../../src/fit/TorsoModel";
import { onModel } from "../../src/drawing/lines/ReferenceLines";
import type { Viewer } from "../../src/viewer/Viewer";
import shared from "./dual_quaternions.json" with { type: "json" };

const TOLERANCE = 2e-5; // metres: single precision 20 m away

async function loaded(): Promise<{ torso: TorsoModel; body: Group }> {
  const body = new Group();
  body.rotation.set(0.4, -1, 2); // turned upright for looking
  const glb = Uint8Array.from(atob(shared.glb), (letter) => letter.charCodeAt(0)).buffer;
  const model = { glb, side: { skinning: "dual_quaternion" } } as unknown as Model;
  const viewer = { beforeFrame: new Set(), body, inHalf: () => undefined } as unknown as Viewer;
  const torso = await new Promise<TorsoModel>((resolve) => {
    const made = new TorsoModel(viewer, (error) => {
      expect(error).toBeNull();
      resolve(made);
    });
    made.update({ scan: {}, models: { "": model } } as unknown as Parameters<TorsoModel["update"]>[0]);
  });
  return { torso, body };
}

test("what is shown, and what lies on it, is where the service has it; its triangles are the model's", async () => {
  const { torso, body } = await loaded();
  for (const { nodes, vertices } of shared.poses) {
    torso.apply(nodes);
    const shown: Mesh[] = [];
    body.traverse((node) => {
      if (node instanceof Mesh && node.visible) shown.push(node as Mesh);
    });
    expect(shown).toHaveLength(3); // depth, surface, depth
    for (const mesh of shown) {
      const there = mesh.geometry.attributes.position!;
      vertices.forEach((place, vertex) => {
        const gap = new Vector3().fromBufferAttribute(there, vertex).applyMatrix4(mesh.matrix).distanceTo(new Vector3(...place));
        expect(gap).toBeLessThan(TOLERANCE);
        expect(torso.vertexAt!(vertex, new Vector3()).distanceTo(new Vector3(...place))).toBeLessThan(TOLERANCE);
      });
    }
    const corners = [0, 1, 2].map((k) => new Vector3(...vertices[torso.mesh!.geometry.index!.getX(3 * 50 + k)]!));
    const [line] = onModel([{ name: "one", label: "", closed: false, color: "#101010", surface_points: [{ face: 50, barycentric: [0.2, 0.3, 0.5] }] }], torso, torso.vertexAt!);
    const on = new Vector3().addScaledVector(corners[0]!, 0.2).addScaledVector(corners[1]!, 0.3).addScaledVector(corners[2]!, 0.5);
    const normal = corners[1]!.sub(corners[0]!).cross(corners[2]!.sub(corners[0]!)).normalize();
    expect(new Vector3().fromArray(line!.points).distanceTo(on.addScaledVector(normal, 0.001))).toBeLessThan(TOLERANCE); // it is lifted by 1 mm
  }
});
