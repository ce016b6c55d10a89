// Reads glTF that came as bytes.  Textures go through <img> and not through fetch(blob:), which the page's policy
// (default-src 'self') forbids.  The reader comes with the first body and not with the page.
import { Mesh, type Object3D, TextureLoader } from "three";
import type { GLTF, GLTFLoader } from "three/addons/loaders/GLTFLoader.js";

let coming: Promise<GLTFLoader> | null = null;

async function made(): Promise<GLTFLoader> {
  const loaders = await import("three/addons/loaders/GLTFLoader.js");
  const loader = new loaders.GLTFLoader();
  loader.register((parser) => {
    (parser as unknown as { textureLoader: TextureLoader }).textureLoader = new TextureLoader(parser.options.manager);
    return { name: "textures_as_images" };
  });
  return loader;
}

export async function readGltf(bytes: ArrayBuffer): Promise<GLTF> {
  coming ??= made();
  try {
    return await (await coming).parseAsync(bytes, "");
  } catch (error) {
    coming = null; // the next body asks again for a reader that could not be had
    throw error;
  }
}

export function firstMesh(root: Object3D): Mesh | null {
  let found: Mesh | null = null;
  root.traverse((node) => {
    if (found === null && node instanceof Mesh) found = node;
  });
  return found;
}

/** Frees what a scene holds on the graphics card. */
export function disposeTree(root: Object3D): void {
  root.removeFromParent();
  root.traverse((node) => {
    if (!(node instanceof Mesh)) return;
    const { geometry, material } = node as Mesh;
    geometry.dispose();
    for (const each of [material].flat()) {
      (each as { map?: { dispose(): void } | null }).map?.dispose();
      each.dispose();
    }
  });
}
