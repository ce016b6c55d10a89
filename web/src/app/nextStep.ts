// The one primary button: what the person would do next, from the state alone.
import { isFitting } from "../fit/state";
import { ENOUGH, nextMissing } from "../landmarks/picks";
import { certainNames } from "../landmarks/certain";
import { isLikely, openProposals } from "../landmarks/proposals";
import { askedNames, openQuestions } from "../landmarks/questions";
import { needsConfirming, pickCount } from "../landmarks/state";
import type { Session } from "./session";

/** What of the state decides. */
export type NextShown = Pick<
  Session,
  "meta" | "step" | "loading" | "scan" | "confirmed" | "picks" | "certain" | "proposals" | "skipped" | "active" | "fit" | "isStarting" | "stance" | "drawn" | "stances"
>;

export type NextStep =
  | { kind: "none" }
  | { kind: "confirm scan" }
  | { kind: "place"; landmark: string; isArmed: boolean }
  | { kind: "confirm"; names: readonly string[] }
  | { kind: "fit"; again: boolean; landmarks: number }
  | { kind: "check"; count: number }
  | { kind: "save" };

/** The fit on the screen was given other picks, or was not told which of them are certain. */
function picksChanged({ fit, picks, certain }: NextShown): boolean {
  if (!fit?.picks) return false;
  return fit.picks !== picks.present || certainNames(picks.present, certain).join() !== fit.certain.join();
}

export function nextStep(state: NextShown): NextStep {
  if (!state.scan || state.loading || isFitting(state)) return { kind: "none" };
  if (state.step === "scan" && needsConfirming(state)) return { kind: "confirm scan" };
  const landmarks = pickCount(state);
  if (state.step === "landmarks") {
    const likely = openProposals(state.proposals, state.picks.present).filter((proposal) => isLikely(proposal) && !state.skipped.has(proposal.name));
    if (state.active === null && likely.length > 0) return { kind: "confirm", names: likely.map(({ name }) => name) };
    const list = state.meta?.landmarks ?? [];
    const landmark = state.active ?? nextMissing(list, state.picks.present, state.skipped);
    if (landmark !== null) return { kind: "place", landmark, isArmed: state.active !== null };
  }
  const mayAsk = state.fit?.state === "done" && state.step !== "scan" && state.step !== "drawing";
  const count = mayAsk ? askedNames(openQuestions(state)).size : 0;
  if (count > 0) return { kind: "check", count };
  if (state.fit?.state === "done" && !picksChanged(state)) return { kind: "save" };
  if (state.fit) return { kind: "fit", again: true, landmarks };
  if (state.step === "fit" || landmarks >= ENOUGH) return { kind: "fit", again: false, landmarks };
  const first = nextMissing(state.meta?.landmarks ?? [], state.picks.present, state.skipped);
  return first === null ? { kind: "fit", again: false, landmarks } : { kind: "place", landmark: first, isArmed: false };
}
