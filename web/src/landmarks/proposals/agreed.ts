// Picks that stand where they were proposed: agreeing to a proposal is weak evidence, and the service keeps the proposal's
// own error for them.  A pick counts as a person's own when it was moved, or confirmed where it was looked at closely: then
// it is certain.  Points that only a finger finds cannot be seen however near the eye is.
import type { Vector } from "../../api/types";
import { isCertain } from "../certain";
import type { Picks } from "../picks";
import type { LandmarksSlice } from "../state";

const SAME_MM = 0.05; // as the service compares them; no click meets a proposal so closely
export const CLOSE_PIXELS = 6; // a millimetre, of the page; a few of them are seen one by one, the whole body has one or two
const BY_TOUCH = /^(acromion|midclavicle)(_[LR])?$/; // bone under the skin

type Known = Pick<LandmarksSlice, "picks" | "certain" | "proposals">;

/** Whether a place fills the view so that single millimetres are seen; pixels of the page in a metre there. */
export const isLookedAt = (pixelsPerMetre: number): boolean => pixelsPerMetre >= 1000 * CLOSE_PIXELS;

export const isFelt = (name: string): boolean => BY_TOUCH.test(name);

const isAt = (a: Vector, b: Vector): boolean => Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]) < SAME_MM;

/** The picks that were only agreed to, with the confidence of their proposals. */
export function onlyAgreed({ picks: { present }, certain, proposals }: Known): Readonly<Record<string, number>> {
  if (proposals?.state !== "found") return {};
  const there = (picks: Picks, name: string, point: Vector): boolean => name in picks && isAt(picks[name]!, point) && !isCertain(picks, certain, name);
  return Object.fromEntries(Object.entries(proposals.landmarks).flatMap(([name, { point, confidence }]) => (there(present, name, point) ? [[name, confidence]] : [])));
}
