// A scan with all that the service keeps of it, read at once: for the stance that waits beside the one in work.
import { picksOf } from "../scan/actions";
import type { Client } from "../api/client";
import type { ExampleScan, Frame, Iterated, Started } from "../api/types";
import { fromDrawing } from "../drawing/files";
import { startDrawn } from "../drawing/lines";
import { readDistances } from "../fit/distances";
import { tidyFrame } from "../viewer/frame";
import { startHistory } from "../store/history";
import { frameFromPicks, type Picks } from "../landmarks/picks";
import type { FitState, Session } from "../app/session";
import { text } from "../ui/text";
import type { Slice } from "./state";

/** A fit as its story stands now; its files too when it is done. */
export async function loadFit(client: Client, id: string, picks: Picks | null): Promise<FitState> {
  const told = await client.fit(id);
  const records = await client.story(told.links.events);
  const events = records.map(({ event }) => event);
  const iterations = events.filter((event): event is Iterated => event.kind === "iterated");
  const isDone = told.state === "done";
  const [result, drawing, surface, distances] = isDone
    ? await Promise.all([
        client.result(told.links.result),
        told.drawing === null ? null : client.drawing(told.links.drawing),
        client.bytes(told.links.fitted_ply),
        client.bytes(told.links.distances).then(readDistances, () => null), // a fit of an older version has none
      ])
    : [null, null, null, null];
  return {
    id,
    links: told.links,
    state: told.state === "queued" ? "running" : told.state,
    started: events.find((event): event is Started => event.kind === "started") ?? null,
    iterations,
    shown: iterations.length - 1,
    playing: false,
    result,
    drawing,
    drawingName: told.drawing,
    surface,
    distances,
    reason: told.reason,
    isConnected: true,
    picks,
  };
}

/** How the body stands: by its fit, by its landmarks, or as the service proposes. */
function frameOf(info: ExampleScan, picks: Picks, fit: FitState | null): Pick<NonNullable<Session["scan"]>, "frame" | "frameFrom"> {
  const fitted = fit?.result ? frameFromPicks(picksOf({ landmarks: fit.result.landmarks, unit: fit.result.scan.unit })) : null;
  const straight = fitted ?? frameFromPicks(picks);
  return { frame: straight ?? tidyFrame(info.frame), frameFrom: straight ? "landmarks" : "service" };
}

export async function loadSlice(client: Client, scan: string, fit: string | null, own: Frame | null): Promise<Slice> {
  const info: ExampleScan = await client.scan(scan);
  const [mesh, saved, drawing] = await Promise.all([client.mesh(info), client.landmarks(info), client.ownDrawing(info)]);
  const picks = picksOf(saved);
  const fitted = fit === null ? null : await loadFit(client, fit, picks);
  const stands = own ? ({ frame: tidyFrame(own), frameFrom: "person" } as const) : frameOf(info, picks, fitted);
  return {
    scan: { info, title: text.top.uploaded, mesh, file: null, example: info.example_landmarks ?? null, ...stands },
    picks: startHistory(picks),
    drawn: startDrawn(drawing ? fromDrawing(drawing) : []),
    proposals: null,
    skipped: new Set(),
    saving: "saved",
    stance: "auto",
    fit: fitted,
  };
}
