// Makes a scan's search tree and rims, and finds the patient in it, beside the page, which goes on meanwhile.
import { type Body, type BodyQuestion, bodyOf, type Outline, outlineOf } from "./body";

export interface WorkerQuestion extends BodyQuestion {
  readonly wantsOutline: boolean; // that of the whole scan
}

export interface WorkerAnswer {
  readonly outline?: Outline; // first, where it was asked for
  readonly body?: Body;
}

addEventListener("message", ({ data }: MessageEvent<WorkerQuestion>) => {
  if (data.wantsOutline) {
    const outline = outlineOf(data);
    postMessage({ outline } satisfies WorkerAnswer, { transfer: buffersOfOutline(outline) }); // tens of megabytes: handed over, not copied
  }
  const body = bodyOf(data);
  postMessage({ body } satisfies WorkerAnswer, { transfer: buffersOf(body) });
});

const buffersOfOutline = ({ tree, rims }: Outline): Transferable[] => [...tree.roots, ...(tree.indirectBuffer ? [tree.indirectBuffer.buffer] : []), rims.buffer];

function buffersOf({ drawable: { isSkin, outwards }, part, relief }: Body): Transferable[] {
  const plain = [isSkin, outwards, ...(part ? [part.index, part.faces] : []), ...(relief ? [relief] : [])];
  return [...plain.map(({ buffer }) => buffer), ...(part ? buffersOfOutline(part) : [])];
}
