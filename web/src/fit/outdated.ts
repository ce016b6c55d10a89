// Whether the fit on the screen is still the one that is asked for: other landmarks, cuts and settings make it old.
import { certainNames } from "../landmarks/certain";
import type { Picks } from "../landmarks/picks";
import type { LandmarksSlice } from "../landmarks/state";
import type { ScanSlice } from "../scan/state";
import type { FitSlice } from "./state";
import { isStanceAsked } from "./verdict";

/** gone: all of its landmarks were taken away; the first that holds. */
export type Outdated = "gone" | "landmarks" | "cuts" | "settings" | null;

type Shown = Pick<FitSlice, "fit" | "stance" | "preset" | "refine"> & Pick<LandmarksSlice, "picks" | "certain"> & Pick<ScanSlice, "scan">;

const SAME_MM = 0.01; // what writing a place to a file and reading it leaves; a nudge of one pixel is more

const isSame = (a: Picks, b: Picks): boolean => {
  const names = Object.keys(a);
  return names.length === Object.keys(b).length && names.every((name) => name in b && Math.hypot(...a[name]!.map((value, axis) => value - b[name]![axis]!)) < SAME_MM);
};

export function outdated({ fit, picks, certain, scan, ...now }: Shown): Outdated {
  if (fit === null) return null;
  const given = fit.picks;
  if (given) {
    const present = picks.present;
    if (!isSame(given, present)) return Object.keys(present).length === 0 ? "gone" : "landmarks";
    if (certainNames(present, certain).join() !== fit.certain.join()) return "landmarks";
  }
  const cuts = scan?.cuts ?? null;
  if (fit.cuts !== undefined && cuts !== null && fit.cuts !== cuts) return "cuts";
  const asked = fit.asked;
  if (!asked) return null;
  // What the fit has guessed and asks about is answered by the same word, too.
  const isOtherStance = now.stance !== asked.stance && (now.stance !== fit.result?.stance || isStanceAsked(fit.result));
  return isOtherStance || now.preset !== asked.preset || now.refine !== asked.refine ? "settings" : null;
}
