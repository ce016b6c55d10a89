// Reads glTF that came as bytes.  Textures go through <img> and not through fetch(blob:), which the page's policy
// (default-src 'self') forbids.
import { Mesh, type Object3D, TextureLoader } from "three";
import { type GLTF, GLTFLoader } from "three/addons/loaders/GLTFLoader.js";

const loader = new GLTFLoader();
loader.register((parser) => {
  (parser as unknown as { textureLoader: TextureLoader }).textureLoader = new TextureLoader(parser.options.manager);
  return { name: "textures_as_images" };
});

export const readGltf = (bytes: ArrayBuffer): Promise<GLTF> => loader.parseAsync(bytes, "");

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
