// Makes the search tree of a surface beside the page, which goes on meanwhile: of a million triangles it takes seconds.
import { BufferAttribute, BufferGeometry } from "three";
import { MeshBVH } from "three-mesh-bvh";

export interface TreeQuestion {
  readonly positions: Float32Array;
  readonly index: Uint32Array;
}

addEventListener("message", ({ data: { positions, index } }: MessageEvent<TreeQuestion>) => {
  const geometry = new BufferGeometry().setAttribute("position", new BufferAttribute(positions, 3)).setIndex(new BufferAttribute(index, 1));
  const tree = MeshBVH.serialize(new MeshBVH(geometry, { indirect: true }), { cloneBuffers: false });
  tree.index = null; // whoever asks has it
  postMessage(tree, { transfer: [...tree.roots, ...(tree.indirectBuffer ? [tree.indirectBuffer.buffer] : [])] }); // handed over, not copied
});
