// Asks a worker for the patient in a scan; each scan is asked for once, however often it comes back to the stage.
import type { BufferGeometry } from "three";
import type { Vector } from "../api/types";
import type { Body, BodyQuestion } from "./body";
import BodyWorker from "./body.worker?worker";

const found = new WeakMap<ArrayBuffer, Body>(); // by the scan's file

/** What is known of this scan already. */
export const knownBody = (file: ArrayBuffer): Body | null => found.get(file) ?? null;

function open(): Worker | null {
  try {
    return new BodyWorker();
  } catch {
    return null;
  }
}

/** `whole` is the mesh of `file`.  Where the browser gives no worker, or that fails, the scan stays whole: null. */
export function findBody(file: ArrayBuffer, whole: BufferGeometry, tableNormal: Vector | null): Promise<Body | null> {
  return new Promise((done) => {
    const question: BodyQuestion = {
      positions: Float32Array.from(whole.attributes.position!.array),
      index: Uint32Array.from(whole.index!.array),
      isSplit: whole.hasAttribute("uv"),
      tableNormal,
      wantsRelief: !whole.hasAttribute("uv") && !whole.hasAttribute("color"),
    };
    const worker = open();
    if (!worker) return done(null);
    const end = (body: Body | null): void => {
      worker.terminate();
      if (body) found.set(file, body);
      done(body);
    };
    worker.onmessage = ({ data }: MessageEvent<Body>) => end(data);
    worker.onerror = () => end(null);
    worker.postMessage(question, [question.positions.buffer, question.index.buffer]);
  });
}
