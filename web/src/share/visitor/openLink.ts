// What a visitor's browser may ask: the secret behind # is posted once, then a cookie stands for it.  Read only.
import * as text from "../text";
import { ask, askJson } from "../../api/client";
import type { DrawingFile, Result, Scan, SharedResult } from "../../api/types";
import { readDistances } from "../../fit/distances";
import { frameFromPicks, picksOf } from "../../landmarks/picks";
import { tidyFrame } from "../../viewer/frame";
import { initialVisitor, type VisitorState } from "./state";

/** Opens the link whose secret stands behind #; without one, the link that this browser has open already. */
export function openLink(secret: string, passcode: string): Promise<SharedResult> {
  if (secret === "") return askJson<SharedResult>("/api/shared");
  return askJson<SharedResult>("/api/shared/open", "POST", passcode === "" ? { token: secret } : { token: secret, passcode });
}

/** Everything that the link shows, as the state of a page at rest. */
export async function readShared(shared: SharedResult): Promise<VisitorState> {
  const { links } = shared;
  const bytes = async (path: string): Promise<ArrayBuffer> => (await ask(path)).arrayBuffer();
  const [result, surface, mesh, distances] = await Promise.all([
    askJson<Result>(links.result),
    bytes(links.fitted_ply),
    links.mesh === null ? null : bytes(links.mesh),
    bytes(links.distances),
  ]);
  // A fit without a drawing has none to show.
  const drawing = await askJson<DrawingFile>(links.drawing).catch(() => null);
  const frame = frameFromPicks(picksOf({ landmarks: result.landmarks, unit: result.scan.unit })) ?? tidyFrame({ up: [0, 1, 0], front: [0, 0, 1] });
  // Whether it has colours is the mesh's own matter: a plain one brings none.
  const info = { id: "shared", colours: "vertex" } as Scan;
  return {
    ...initialVisitor,
    step: "result",
    overlay: mesh === null ? "model" : "both",
    scan: { info, title: text.shared.title, mesh, frame, frameFrom: "landmarks", file: null, example: null },
    fit: {
      id: "shared",
      links: { ...initialLinks, result: links.result, fitted_ply: links.fitted_ply, fitted_glb: links.fitted_glb, drawing: links.drawing },
      state: "done",
      started: null,
      iterations: [],
      shown: -1,
      playing: false,
      result,
      drawing,
      drawingName: null,
      surface,
      distances: readDistances(distances),
      reason: null,
      isConnected: true,
      picks: null,
    },
  };
}

const initialLinks = { self: "", events: "", result: "", fitted_glb: "", fitted_ply: "", drawing: "", distances: "", report: "", measures: "", cancel: "", shares: "" };
