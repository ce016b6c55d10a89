// Stands the body upright unless the person has turned it otherwise: by the fitted rig once there is a fit, before by the
// service's proposal, and by landmarks where that is a mere guess or lies the body down.
import type { Frame } from "../api/types";
import type { ScanSlice, ScanState } from "../scan/state";
import { angleBetween, tidyFrame } from "../viewer/frame";
import { fromFront, type ViewSlice } from "../viewer/state";
import { frameFromPicks, type Picks } from "./picks";

type State = Pick<ScanSlice & ViewSlice, "scan" | "view">;
type Stands = Pick<ScanState, "frame" | "frameFrom">;

const WORTH_DEGREES = 2; // less is not seen, and moving the view would only disturb
const GUESS = 0.5; // a proposal with less confidence is a guess from the scan's longer side
const WRONG_DEGREES = 30; // farther from the landmarks than any lean: the proposal is wrong

/** How a scan stands by the service's proposal and by its landmarks. */
export function standing(proposed: Frame & { readonly confidence: number }, picks: Picks): Stands {
  const service = tidyFrame(proposed);
  const placed = frameFromPicks(picks);
  const isBetter = placed !== null && (proposed.confidence < GUESS || angleBetween(service, placed) > WRONG_DEGREES);
  return isBetter ? { frame: placed, frameFrom: "landmarks" } : { frame: service, frameFrom: "service" };
}

function turnedTo({ scan, view }: State, { frame, frameFrom }: Stands): Partial<State> {
  if (!scan || angleBetween(scan.frame, frame) < WORTH_DEGREES) return {};
  return { scan: { ...scan, frame, frameFrom }, ...fromFront({ view }) };
}

/** By landmarks, where nothing better is known; by the proposal again, where they do not contradict it any more. */
export function straightened(state: State, picks: Picks): Partial<State> {
  const from = state.scan?.frameFrom;
  if (!state.scan || from === "person" || from === "fit") return {};
  return turnedTo(state, standing(state.scan.info.frame, picks));
}

/** By the fitted rig; null where a result does not tell how its bones lie. */
export function straightenedByFit(state: State, frame: Frame | null): Partial<State> {
  return frame === null || state.scan?.frameFrom === "person" ? {} : turnedTo(state, { frame, frameFrom: "fit" });
}
