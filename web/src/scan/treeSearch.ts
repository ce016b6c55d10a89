// The search tree of a scan's skin, by which it is picked and drawn on: made once for each scan and for what of it is cut away by
// hand, however often it comes back to the stage.
import type { SerializedBVH } from "three-mesh-bvh";
import type { Crops } from "./crop";
import type { TreeQuestion } from "./tree.worker";
import TreeWorker from "./tree.worker?worker";

const made = new WeakMap<ArrayBuffer, WeakMap<Crops, Promise<SerializedBVH>>>(); // by the scan's file

/** `index`: the triangles of the scan that are left. */
export function treeOf(file: ArrayBuffer, crops: Crops, positions: ArrayLike<number>, index: Uint32Array): Promise<SerializedBVH> {
  const of = made.get(file) ?? new WeakMap<Crops, Promise<SerializedBVH>>();
  made.set(file, of);
  const known = of.get(crops);
  if (known) return known;
  const worker = new TreeWorker();
  const found = new Promise<SerializedBVH>((done, failed) => {
    worker.onmessage = ({ data }: MessageEvent<SerializedBVH>) => done(data);
    worker.onerror = () => failed(new Error("no search tree"));
    const question: TreeQuestion = { positions: new Float32Array(positions), index: index.slice() };
    worker.postMessage(question, [question.positions.buffer, question.index.buffer]);
  }).finally(() => worker.terminate());
  found.catch(() => of.delete(crops));
  of.set(crops, found);
  return found;
}
