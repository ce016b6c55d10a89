// Reads a surface that came as PLY.  The reader comes with the first surface and not with the page.
import { BufferAttribute, BufferGeometry } from "three";

/** Triangles as numbers: places, three for each vertex, in the file's unit, and vertices, three for each triangle. */
export interface Triangles {
  readonly places: Float32Array;
  readonly corners: Uint16Array | Uint32Array;
}

export async function readPly(bytes: ArrayBuffer): Promise<Triangles> {
  const { PLYLoader } = await import("three/addons/loaders/PLYLoader.js");
  const { attributes, index } = new PLYLoader().parse(bytes);
  return { places: attributes.position!.array as Float32Array, corners: index!.array as Uint32Array };
}

/** In metres, of places in a unit of so many metres. */
export function geometryOf({ places, corners }: Triangles, metresPerUnit: number): BufferGeometry {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(places.map((value) => value * metresPerUnit), 3));
  geometry.setIndex(new BufferAttribute(corners, 1));
  return geometry;
}
