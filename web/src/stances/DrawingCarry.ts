// The drawing on the other stance: what is missing for it, and how sure its place is.
import type { DrawingSlice } from "../drawing/state";
import type { FitSlice } from "../fit/state";
import type { ScanSlice } from "../scan/state";
import type { PageSlice } from "../store/page";
import { only } from "../store/store";
import { button, problem } from "../ui/controls";
import { el, setText, show } from "../ui/dom";
import type { Panel } from "../ui/Panel";
import { formatMm } from "../ui/units";
import type { StancesActions } from "./actions";
import { carriedNote } from "./carry";
import { stanceNames, type StancesSlice } from "./state";
import * as text from "./text";

const words = text.stances.carry;

type Shown = Pick<PageSlice & ScanSlice & FitSlice & DrawingSlice & StancesSlice, "problems" | "scan" | "stance" | "fit" | "drawn" | "stances">;

export function createDrawingCarry(stances: StancesActions): Panel<Shown> {
  const says = el("p", { class: "muted small" });
  const note = el("p", { class: "look-here small" });
  const add = button(text.stances.add, () => stances.dialog(true), "quiet outlined wide");
  const wrong = problem(() => stances.dismiss());
  const element = el("div", { class: "panel carry" }, el("p", { class: "label" }, words.title), wrong.element, says, add, note);

  function sentence(state: Shown): { says: string; note: string } {
    const { other, isCarrying } = state.stances;
    const quiet = { note: "" };
    if (!other) return { says: words.needsOther, ...quiet };
    const [mine, its] = stanceNames(state);
    const missing = [...(state.fit?.state === "done" ? [] : [mine]), ...(other.fit?.state === "done" ? [] : [its])];
    if (missing.length > 0) return { says: words.needsFits(missing.join(", ")), ...quiet };
    if (state.drawn.lines.present.length + other.drawn.lines.present.length === 0) return { says: words.needsLines, ...quiet };
    if (isCarrying) return { says: words.busy, ...quiet };
    const shown = other.drawn.carried ?? state.drawn.carried;
    if (!shown) return { says: words.ready(its), ...quiet };
    const there = other.drawn.carried !== null;
    const { from, to, bridged, points } = carriedNote(shown.drawing);
    const [source, goal] = there ? [mine, its] : [its, mine];
    const distances = from && to ? words.note(source, formatMm(from.mean), formatMm(from.p95), goal, formatMm(to.mean), formatMm(to.p95)) : "";
    return { says: words.done(goal), note: [distances, bridged > 0 ? words.bridged(bridged, points) : ""].filter((each) => each !== "").join(" ") };
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
      show(add, other === null);
      wrong.set(other ? state.problems.stances : undefined);
    },
  };
}
