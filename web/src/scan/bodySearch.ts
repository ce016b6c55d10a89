// Asks a worker for a scan's outline and for the patient in it; each scan is asked for once, however often it comes back to the
// stage, and for the patient once again with each part of it that is hidden by hand.
import type { BufferGeometry } from "three";
import { type Body, type CutByService, type Outline, outlineOf } from "./body";
import type { WorkerAnswer, WorkerQuestion } from "./body.worker";
import type { Crops } from "./crop";
import BodyWorker from "./body.worker?worker";

const found = new WeakMap<ArrayBuffer, WeakMap<Crops, Body>>(); // by the scan's file, and what of it is hidden
const outlines = new WeakMap<ArrayBuffer, Outline>(); // by the scan's file

/** What is known of this scan already. */
export const knownBody = (file: ArrayBuffer, crops: Crops): Body | null => found.get(file)?.get(crops) ?? null;
export const knownOutline = (file: ArrayBuffer): Outline | null => outlines.get(file) ?? null;

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

interface Later<T> {
  readonly promise: Promise<T>;
  readonly resolve: (value: T) => void;
}

function later<T>(): Later<T> {
  let resolve!: (value: T) => void;
  const promise = new Promise<T>((done) => {
    resolve = done;
  });
  return { promise, resolve };
}

export interface Search {
  /** Where the browser gives no worker, or that fails, the page makes it itself. */
  readonly outline: Promise<Outline>;
  /** Where the browser gives no worker, or that fails, the scan stays whole: null. */
  readonly body: Promise<Body | null>;
}

/** `whole` is the mesh of `file`. */
export function searchScan(file: ArrayBuffer, whole: BufferGeometry, cut: CutByService, crops: Crops): Search {
  const known = knownOutline(file);
  const surface = () => ({
    positions: new Float32Array(whole.attributes.position!.array),
    index: new Uint32Array(whole.index!.array),
    isSplit: whole.hasAttribute("uv"),
  });
  const outline = later<Outline>();
  const body = later<Body | null>();
  const takeOutline = (of: Outline): void => {
    outlines.set(file, of);
    outline.resolve(of);
  };
  const takeBody = (of: Body | null): void => {
    if (of) remember(file, crops, of);
    else if (!knownOutline(file)) takeOutline(outlineOf(surface()));
    body.resolve(of);
  };
  if (known) outline.resolve(known);
  const worker = open();
  if (!worker) {
    takeBody(null);
    return { outline: outline.promise, body: body.promise };
  }
  const end = (of: Body | null): void => {
    worker.terminate();
    takeBody(of);
  };
  worker.onmessage = ({ data }: MessageEvent<WorkerAnswer>) => {
    if (data.outline) takeOutline(data.outline);
    if (data.body) end(data.body);
  };
  worker.onerror = () => end(null);
  const wantsRelief = !whole.hasAttribute("uv") && !whole.hasAttribute("color");
  const question: WorkerQuestion = { ...surface(), cut, crops, wantsRelief, wantsOutline: !known };
  worker.postMessage(question, [question.positions.buffer, question.index.buffer]);
  return { outline: outline.promise, body: body.promise };
}
