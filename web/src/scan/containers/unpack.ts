// Asks a worker for the plain triangles of a file.
import type { ContainerAnswer, ContainerQuestion } from "./container.worker";
import ContainerWorker from "./container.worker?worker";
import type { ContainerKind } from "./kind";
import { MOST_BYTES, MOST_SECONDS } from "./limits";
import * as text from "./text";

/** A plain GLB.  Rejects with a sentence. */
export async function unpack(file: File, kind: ContainerKind): Promise<File> {
  if (file.size > MOST_BYTES) throw new Error(text.unpacksTooLarge(MOST_BYTES / 2 ** 20));
  const bytes = await file.arrayBuffer();
  return new Promise((done, refuse) => {
    let worker: Worker;
    try {
      worker = new ContainerWorker();
    } catch {
      return refuse(new Error(text.noWorker));
    }
    const end = (act: () => void): void => {
      clearTimeout(timer);
      worker.terminate();
      act();
    };
    const timer = setTimeout(() => end(() => refuse(new Error(text.tooLong))), 1000 * MOST_SECONDS);
    worker.onmessage = ({ data }: MessageEvent<ContainerAnswer>) =>
      end(() => ("glb" in data ? done(new File([data.glb], text.unpacked)) : refuse(new Error(data.problem))));
    worker.onerror = () => end(() => refuse(new Error(text.damaged)));
    worker.postMessage({ kind, bytes } satisfies ContainerQuestion, [bytes]);
  });
}
