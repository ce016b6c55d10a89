// Stands the body upright by landmarks as soon as they say how, unless the person has turned it otherwise.
import type { ScanSlice } from "../scan/state";
import { angleBetween } from "../viewer/frame";
import { fromFront, type ViewSlice } from "../viewer/state";
import { frameFromPicks, type Picks } from "./picks";

type State = Pick<ScanSlice & ViewSlice, "scan" | "view">;

const WORTH_DEGREES = 2; // less is not seen, and moving the view would only disturb

export function straightened(state: State, picks: Picks): Partial<State> {
  const { scan } = state;
  const frame = frameFromPicks(picks);
  if (!scan || scan.frameFrom === "person" || !frame || angleBetween(scan.frame, frame) < WORTH_DEGREES) return {};
  return { scan: { ...scan, frame, frameFrom: "landmarks" }, ...fromFront(state) };
}
