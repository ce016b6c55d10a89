// The plan on the other scan: what is missing for it, and how sure its place is.
import type { DrawingSlice } from "../drawing/state";
import type { FitSlice } from "../fit/state";
import type { ScanSlice } from "../scan/state";
import { inStance } from "../scan/text";
import type { PageSlice } from "../store/page";
import { only } from "../store/store";
import { button, problem } from "../ui/controls";
import { el, setText, show } from "../ui/dom";
import type { Panel } from "../ui/Panel";
import { wideOf } from "../fit/fingers";
import type { StancesActions } from "./actions";
import { carriedNote } from "./carry";
import { samePatient } from "./samePatientText";
import { isPredicted, stanceNames, stanceOf, type StancesSlice } from "./state";
import * as text from "./text";

const words = text.stances.carry;

type Shown = Pick<PageSlice & ScanSlice & FitSlice & DrawingSlice & StancesSlice, "problems" | "scan" | "stance" | "fit" | "drawn" | "stances">;

export function createDrawingCarry(stances: StancesActions): Panel<Shown> {
  const says = el("p", { class: "muted small" });
  const note = el("p", { class: "look-here small" });
  const wrong = problem(() => stances.dismiss());
  const answer = button(samePatient.answer, () => stances.askAgain(), "outlined wide");
  const element = el("div", { class: "panel carry" }, el("p", { class: "label" }, words.title), wrong.element, says, note, answer);

  function sentence(state: Shown): { says: string; note: string } {
    const { other, isCarrying } = state.stances;
    const quiet = { note: "" };
    if (!other) return { says: "", ...quiet };
    const [mine, its] = stanceNames(state);
    const missing = [...(state.fit?.state === "done" ? [] : [mine]), ...(other.fit?.state === "done" ? [] : [its])];
    if (missing.length > 0) return { says: words.needsFits(missing.join(", ")), ...quiet };
    if (state.stances.unanswered.length > 0) return { says: "", note: samePatient.left };
    if (isCarrying) return { says: words.busy, ...quiet };
    const shown = [other.drawn.onScan?.carried, state.drawn.onScan?.carried].filter((each) => each && each.shapes.length > 0);
    if (shown.length === 0) return { says: words.needsLines, ...quiet };
    const notes = carriedNote({ shapes: shown.flatMap((each) => each!.shapes) });
    const goals = shown.length === 2 ? [mine, its] : [other.drawn.onScan?.carried.shapes.length ? its : mine];
    const untold = (other.drawn.onScan?.plan.missing ?? []).map(({ reason }) => reason);
    const doubts = [...(state.drawn.onScan?.plan.doubts ?? []), ...(other.drawn.onScan?.plan.doubts ?? [])];
    const said = [
      ...doubts.slice(0, 1), // both say the same of the same two bodies
      notes.error === null ? "" : words.error(wideOf(notes.error)),
      notes.bridged > 0 ? words.bridged(notes.bridged, notes.points) : "",
      ...new Set(untold),
    ];
    const says = isPredicted(other) ? words.donePredicted(inStance(stanceOf(other))) : words.done(goals);
    return { says, note: said.filter((each) => each !== "").join(" ") };
  }

  return {
    element,
    select: only("problems", "scan", "stance", "fit", "drawn", "stances"),
    update(state: Shown): void {
      const now = sentence(state);
      const { other } = state.stances;
      setText(says, now.says);
      show(says, now.says !== "");
      setText(note, now.note);
      show(note, now.note !== "");
      show(answer, state.stances.unanswered.length > 0);
      show(element, other !== null);
      wrong.set(other ? state.problems.stances : undefined);
    },
  };
}
