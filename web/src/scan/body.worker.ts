// Finds the patient in a scan beside the page, which goes on meanwhile.
import { type Body, type BodyQuestion, bodyOf } from "./body";

addEventListener("message", ({ data }: MessageEvent<BodyQuestion>) => {
  const body = bodyOf(data);
  postMessage(body, { transfer: buffersOf(body) }); // some ten megabytes: handed over, not copied
});

function buffersOf({ drawable: { isSkin, outwards }, part, relief }: Body): Transferable[] {
  const hers = part ? [part.index, part.faces, part.rims, ...(part.tree.indirectBuffer ? [part.tree.indirectBuffer] : [])] : [];
  return [...[isSkin, outwards, ...hers, ...(relief ? [relief] : [])].map(({ buffer }) => buffer), ...(part?.tree.roots ?? [])];
}
