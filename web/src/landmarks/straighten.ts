// Stands the body upright by landmarks as soon as they say how, unless the person has turned it otherwise.
import { angleBetween } from "../viewer/frame";
import { frameFromPicks, type Picks } from "./picks";
import type { Session } from "../app/session";

const WORTH_DEGREES = 2; // less is not seen, and moving the view would only disturb

export function straightened(state: Session, picks: Picks): Partial<Session> {
  const { scan } = state;
  const frame = frameFromPicks(picks);
  if (!scan || scan.frameFrom === "person" || !frame || angleBetween(scan.frame, frame) < WORTH_DEGREES) return {};
  return { scan: { ...scan, frame, frameFrom: "landmarks" }, view: { name: "front", asked: state.view.asked + 1 } };
}
