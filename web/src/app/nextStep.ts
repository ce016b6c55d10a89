// The one primary button: what the person would do next, from the state alone.
import { openDoubt } from "../checks/doubts";
import { areChecksAwaited, areChecksKnown, stepsOf } from "../checks/state";
import { outdated } from "../fit/outdated";
import { isFitting } from "../fit/state";
import { levelOf } from "../fit/verdict";
import { isMark, openLines } from "../ink/state";
import { ENOUGH, nextMissing } from "../landmarks/picks";
import { isSeen, openProposals } from "../landmarks/proposals/proposals";
import { pickCount } from "../landmarks/state";
import { cropsOf } from "../scan/crop";
import { scannedOther, stanceNames, stanceOf, unscanned } from "../stances/state";
import type { Session } from "./session";

/** What of the state decides. */
export type NextShown = Pick<
  Session,
  "asked" | "meta" | "step" | "loading" | "scan" | "confirmed" | "picks" | "certain" | "proposals" | "skipped" | "active" | "fit" | "isStarting" | "stance" | "preset" | "refine" | "drawing" | "drawn" | "ink" | "stances" | "checks"
>;

export type NextStep =
  | { kind: "none" }
  | { kind: "place"; landmark: string; isArmed: boolean }
  | { kind: "confirm"; names: readonly string[] }
  | { kind: "fit"; again: boolean; landmarks: number; isProposed?: boolean } // isProposed: others are proposed and open
  | { kind: "check"; count: number; on: string | null } // points and questions; `on`: the other scan
  | { kind: "correct" } // a fit that is not usable: its landmarks are looked at again
  | { kind: "ink"; count: number; on: string | null } // lines found on the skin, about which nobody has decided; `on`: the other scan
  | { kind: "plan" }
  | { kind: "draw"; isArmed: boolean }
  | { kind: "add"; stance: "standing" | "supine" }
  | { kind: "change over"; to: string }
  | { kind: "wait" } // for what is worth checking on the plan that has just changed
  | { kind: "print" } // on to the printed pages
  | { kind: "report" };

/** Her own lines: on neither scan may they be passed by unseen. */
export function foundInk(state: NextShown): NextStep | null {
  const other = scannedOther(state.stances);
  const open = ({ scan, drawn }: Pick<NextShown, "scan" | "drawn">): number =>
    scan ? openLines(state.ink[scan.info.id], drawn.decided, cropsOf(scan)).filter((line) => !isMark(line)).length : 0;
  const here = open(state);
  if (here > 0) return state.step === "plan" ? null : { kind: "ink", count: here, on: null }; // there they stand above everything else
  const there = other ? open(other) : 0;
  return there > 0 ? { kind: "ink", count: there, on: stanceNames(state)[1] } : null;
}

export const isPlanned = ({ drawing, drawn }: Pick<NextShown, "drawing" | "drawn">): boolean => drawing !== "" || drawn.lines.present.length > 0 || drawn.lesions.length > 0;

/** A surgeon's next steps with a good fit: the pen markings, a drawing, the other stance, the report. */
function afterFit(state: NextShown): NextStep {
  const { drawn, stances } = state;
  if (levelOf(state.fit?.result) === "unusable") return { kind: "correct" };
  const ink = foundInk(state);
  if (ink) return ink;
  if (state.step === "handover") return { kind: "report" };
  if (state.step !== "plan") return { kind: "plan" };
  if (!isPlanned(state) && !(stances.other && isPlanned(stances.other))) return { kind: "draw", isArmed: drawn.tool !== "none" };
  const wanted = stanceOf(state) === "standing" ? "supine" : "standing";
  const print: NextStep = [state, scannedOther(stances)].some((each) => each && areChecksAwaited({ checks: state.checks, fit: each.fit })) ? { kind: "wait" } : { kind: "print" };
  if (stances.other === null) return unscanned(state).includes(wanted) ? { kind: "add", stance: wanted } : print;
  if (stances.other.fit?.state !== "done") return { kind: "change over", to: stanceNames(state)[1] };
  const there = stepsOf({ ...state, ...stances.other }).length;
  return there > 0 ? { kind: "check", count: there, on: stanceNames(state)[1] } : print;
}

export function nextStep(state: NextShown): NextStep {
  if (!state.scan || state.loading || isFitting(state) || state.checks.tour || openDoubt(state)) return { kind: "none" };
  const landmarks = pickCount(state);
  if (state.step === "points") {
    const open = openProposals(state.proposals, state.picks.present).filter(({ name }) => !state.skipped.has(name));
    const seen = open.filter(isSeen);
    if (state.active === null && seen.length > 0) return { kind: "confirm", names: seen.map(({ name }) => name) };
    if (state.active === null && open.length > 0 && state.fit === null) return { kind: "fit", again: false, landmarks, isProposed: true };
    const list = state.meta?.landmarks ?? [];
    const landmark = state.active ?? nextMissing(list, state.picks.present, state.skipped);
    if (landmark !== null) return { kind: "place", landmark, isArmed: state.active !== null };
  }
  const mayAsk = state.fit?.state === "done" && outdated(state) === null && state.step !== "handover";
  if (mayAsk && !areChecksKnown(state)) return { kind: "none" }; // a moment: the button does not change under a finger
  const count = mayAsk ? stepsOf(state).length : 0;
  if (count > 0) return { kind: "check", count, on: null };
  if (state.fit?.state === "done" && outdated(state) === null) return afterFit(state);
  if (state.fit) return { kind: "fit", again: true, landmarks };
  if (state.step === "body" || landmarks >= ENOUGH) return { kind: "fit", again: false, landmarks };
  const first = nextMissing(state.meta?.landmarks ?? [], state.picks.present, state.skipped);
  return first === null ? { kind: "fit", again: false, landmarks } : { kind: "place", landmark: first, isArmed: false };
}
