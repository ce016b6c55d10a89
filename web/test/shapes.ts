// Scans made of plain shapes: half a ball, plates with air between them.
import { BufferGeometry, Float32BufferAttribute, SphereGeometry } from "three";
import { mergeGeometries } from "three/addons/utils/BufferGeometryUtils.js";
import { MeshBVH } from "three-mesh-bvh";

export const place = (geometry: BufferGeometry, x: number, y: number, z: number): BufferGeometry => geometry.translate(x, y, z);

/** Only triangles whose centre is kept; metres. */
export function cut(geometry: BufferGeometry, keeps: (x: number, y: number, z: number) => boolean): BufferGeometry {
  const at = geometry.attributes.position!;
  const index = [...geometry.index!.array];
  const kept = index.flatMap((_, i) => {
    if (i % 3 !== 0) return [];
    const corners = index.slice(i, i + 3);
    const middle = (axis: "getX" | "getY" | "getZ"): number => corners.reduce((sum, corner) => sum + at[axis](corner), 0) / 3;
    return keeps(middle("getX"), middle("getY"), middle("getZ")) ? corners : [];
  });
  return new BufferGeometry().setAttribute("position", at).setIndex(kept);
}

export function made(...parts: BufferGeometry[]): BufferGeometry {
  const bare = parts.map((part) => new BufferGeometry().setAttribute("position", new Float32BufferAttribute(part.attributes.position!.array, 3)).setIndex([...part.index!.array]));
  const all = mergeGeometries(bare);
  all.boundsTree = new MeshBVH(all, { indirect: true });
  return all;
}

export const half = (): BufferGeometry => cut(new SphereGeometry(0.1, 96, 64).rotateX(Math.PI / 2), (_x, _y, z) => z > 0);
