// What a visitor's browser may ask: the secret behind # is posted once, then a cookie of this share alone stands for it.
// Read only.  Each opened link has an address of its own, at which it can be loaded again as long as the browser runs.
import * as text from "../text";
import { ApiError, ask, askJson } from "../../api/client";
import type { DrawingFile, PlanOnScan, Result, Scan, SharedResult } from "../../api/types";
import { readDistances } from "../../fit/distances/distances";
import { blankFit } from "../../fit/state";
import { frameOfRig } from "../../fit/upright";
import { frameFromPicks, picksOf } from "../../landmarks/picks";
import { tidyFrame } from "../../viewer/frame";
import { readPly } from "../../viewer/ply";
import { initialVisitor, type VisitorState } from "./state";

export interface Visit {
  readonly secret: string; // of a link that was followed, else ""
  readonly share: string; // id of a share that was opened in this browser before, else ""
}

export const visitOf = (secret: string, path: string): Visit => ({ secret, share: secret === "" ? (path.split("/")[2] ?? "") : "" });

/** Opens the link; its page has an address of its own from then on. */
export async function openLink({ secret, share }: Visit, passcode: string, past: History): Promise<SharedResult> {
  if (secret === "") return askJson<SharedResult>(`/api/shared/${encodeURIComponent(share)}`);
  const shared = await askJson<SharedResult>("/api/shared/open", "POST", passcode === "" ? { token: secret } : { token: secret, passcode });
  past.replaceState(null, "", `/s/${shared.id}`);
  return shared;
}

/** Ends the visit, on the service too; one that has ended already is no error. */
export async function closeLink({ links }: SharedResult): Promise<void> {
  try {
    await ask(links.close, { method: "POST" });
  } catch (error) {
    if (!(error instanceof ApiError) || error.status !== 401) throw error;
  }
}

const TRIES = 20;
const WAIT_MS = 3000; // what the service says in Retry-After

/** The service sends only so many large files at once. */
async function bytes(path: string): Promise<ArrayBuffer> {
  for (let left = TRIES; ; left -= 1) {
    try {
      return await (await ask(path)).arrayBuffer();
    } catch (error) {
      const isBusy = error instanceof ApiError && (error.status === 503 || error.status === 429);
      if (!isBusy || left === 0) throw error;
      await new Promise((later) => setTimeout(later, WAIT_MS));
    }
  }
}

/** Everything that the link shows, as the state of a page at rest. */
export async function readShared(shared: SharedResult): Promise<VisitorState> {
  const { links } = shared;
  const [result, surface, mesh, distances, plan] = await Promise.all([
    askJson<Result>(links.result),
    bytes(links.fitted_ply).then(readPly),
    links.mesh === null ? null : bytes(links.mesh),
    links.distances === null ? null : bytes(links.distances),
    askJson<PlanOnScan>(links.plan),
  ]);
  // A fit without a drawing has none to show; the plan is all of it, once there is one.
  const brought = plan.whole ? null : await askJson<DrawingFile>(links.drawing).catch(() => null);
  const shapes = [...(brought?.shapes ?? []), ...plan.shapes];
  const drawing: DrawingFile | null = shapes.length > 0 ? { schema: "breastrig/drawing@1", unit: plan.unit, shapes } : null;
  const frame = frameOfRig(result) ?? frameFromPicks(picksOf({ landmarks: result.landmarks, unit: result.scan.unit })) ?? tidyFrame({ up: [0, 1, 0], front: [0, 0, 1] });
  // Whether it has colours is the mesh's own matter: a plain one brings none.
  const info = { id: "shared", colours: "vertex", stance: { proposed: result.stance, reason: "" }, frame: { ...frame, confidence: 1, reason: "" } } as Scan;
  return {
    ...initialVisitor,
    plan,
    step: "handover",
    overlay: mesh === null ? "model" : "both",
    scan: { info, title: text.shared.title, mesh, frame, frameFrom: "fit", file: null, example: null },
    fit: {
      ...blankFit("shared", { ...initialLinks, result: links.result, fitted_ply: links.fitted_ply, fitted_glb: links.fitted_glb, drawing: links.drawing }),
      state: "done",
      result,
      drawing,
      surface,
      distances: distances && readDistances(distances),
    },
  };
}

const initialLinks = { self: "", events: "", result: "", result_zip: "", fitted_glb: "", fitted_ply: "", drawing: "", distances: "", uncertainty: "", checks: "", plan: "", report: "", measures: "", cancel: "", moved: "", shares: "", predictions: "" };
