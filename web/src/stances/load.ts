// A scan with all that the service keeps of it, read at once: for the stance that waits beside the one in work.
import type { Client } from "../api/client";
import type { ExampleScan, Frame, Iterated, Started } from "../api/types";
import { startDrawn } from "../drawing/state";
import { readDistances } from "../fit/distances/distances";
import { blankFit, type FitState } from "../fit/state";
import type { LandmarkActions } from "../landmarks/actions";
import { certainAt } from "../landmarks/certain";
import type { PlanActions } from "../plan/actions";
import { frameFromPicks, type Picks, picksOf } from "../landmarks/picks";
import { cropsFrom } from "../scan/crop";
import type { ScanState } from "../scan/state";
import { uploaded } from "../scan/text";
import { startHistory } from "../store/history";
import { tidyFrame } from "../viewer/frame";
import { readPly } from "../viewer/ply";
import { predictedOf, type Workspace } from "./state";

/** A fit with its events so far; its files too when it is done. */
export async function loadFit(client: Client, id: string, picks: Picks | null, certain: readonly string[]): Promise<FitState> {
  const fit = await client.fit(id);
  const records = await client.allEvents(fit.links.events);
  const events = records.map(({ event }) => event);
  const iterations = events.filter((event): event is Iterated => event.kind === "iterated");
  const isDone = fit.state === "done";
  const [result, drawing, surface, distances] = isDone
    ? await Promise.all([
        client.result(fit.links.result),
        fit.drawing === null ? null : client.drawing(fit.links.drawing),
        client.bytes(fit.links.fitted_ply).then(readPly),
        client.bytes(fit.links.distances).then(readDistances, () => null), // a fit of an older version has none
      ])
    : [null, null, null, null];
  return {
    ...blankFit(id, fit.links),
    state: fit.state === "queued" ? "running" : fit.state,
    started: events.find((event): event is Started => event.kind === "started") ?? null,
    iterations,
    shown: iterations.length - 1,
    result,
    drawing,
    drawingName: fit.drawing,
    surface,
    distances,
    reason: fit.reason,
    picks,
    certain,
    cuts: fit.cuts,
    ...(fit.predicted_from == null ? {} : { predictedFrom: fit.predicted_from }),
  };
}

/** How the body stands: by its fit, by its landmarks, or as the service proposes. */
function frameOf(info: ExampleScan, picks: Picks, fit: FitState | null): Pick<ScanState, "frame" | "frameFrom"> {
  const fitted = fit?.result ? frameFromPicks(picksOf({ landmarks: fit.result.landmarks, unit: fit.result.scan.unit })) : null;
  const straight = fitted ?? frameFromPicks(picks);
  return { frame: straight ?? tidyFrame(info.frame), frameFrom: straight ? "landmarks" : "service" };
}

export async function loadWorkspace(client: Client, landmarks: Pick<LandmarkActions, "read">, plan: Pick<PlanActions, "read">, scan: string, fit: string | null, own: Frame | null): Promise<Workspace> {
  const info: ExampleScan = await client.scan(scan);
  const [mesh, saved, planned, { cuts, digest }] = await Promise.all([client.mesh(info), landmarks.read(info), plan.read(info), client.cuts(info)]);
  const { picks } = saved;
  const fitted = fit === null ? null : await loadFit(client, fit, picks, saved.certain);
  const stands = own ? ({ frame: tidyFrame(own), frameFrom: "person" } as const) : frameOf(info, picks, fitted);
  const loaded: Workspace = {
    scan: { info, title: uploaded, mesh, file: null, example: info.example_landmarks ?? null, crops: startHistory(cropsFrom(cuts)), cuts: digest, ...stands },
    picks: startHistory(picks),
    certain: certainAt(picks, saved.certain),
    drawn: startDrawn(planned.lines, planned),
    proposals: null,
    skipped: new Set(),
    saving: saved.saving,
    stance: "auto",
    drawing: planned.drawing,
    fit: fitted,
  };
  return fitted?.predictedFrom === undefined ? loaded : predictedOf(loaded, fitted);
}
