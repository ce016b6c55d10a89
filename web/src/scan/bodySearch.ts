// Asks a worker for the patient in a scan; each scan is asked for once, however often it comes back to the stage, and once
// again for each part of it that is hidden by hand.
import type { BufferGeometry } from "three";
import type { Vector } from "../api/types";
import type { Body, BodyQuestion } from "./body";
import type { Crops } from "./crop";
import BodyWorker from "./body.worker?worker";

const found = new WeakMap<ArrayBuffer, WeakMap<Crops, Body>>(); // by the scan's file, and what of it is hidden

/** What is known of this scan already. */
export const knownBody = (file: ArrayBuffer, crops: Crops): Body | null => found.get(file)?.get(crops) ?? null;

function remember(file: ArrayBuffer, crops: Crops, body: Body): void {
  const of = found.get(file) ?? new WeakMap<Crops, Body>();
  found.set(file, of.set(crops, body));
}

function open(): Worker | null {
  try {
    return new BodyWorker();
  } catch {
    return null;
  }
}

/** `whole` is the mesh of `file`.  Where the browser gives no worker, or that fails, the scan stays whole: null. */
export function findBody(file: ArrayBuffer, whole: BufferGeometry, tableNormal: Vector | null, crops: Crops): Promise<Body | null> {
  return new Promise((done) => {
    const question: BodyQuestion = {
      positions: new Float32Array(whole.attributes.position!.array),
      index: new Uint32Array(whole.index!.array),
      isSplit: whole.hasAttribute("uv"),
      tableNormal,
      crops,
      wantsRelief: !whole.hasAttribute("uv") && !whole.hasAttribute("color"),
    };
    const worker = open();
    if (!worker) return done(null);
    const end = (body: Body | null): void => {
      worker.terminate();
      if (body) remember(file, crops, body);
      done(body);
    };
    worker.onmessage = ({ data }: MessageEvent<Body>) => end(data);
    worker.onerror = () => end(null);
    worker.postMessage(question, [question.positions.buffer, question.index.buffer]);
  });
}
