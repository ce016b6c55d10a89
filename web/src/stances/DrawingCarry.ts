// The drawing on the other stance: what is missing for it, and how sure its place is.
import type { Actions } from "../app/actions";
import { el, setText, show } from "../ui/dom";
import type { Session } from "../app/session";
import { carriedNote } from "./carry";
import { stanceNames } from "./state";
import { text } from "../ui/text";
import { formatMm } from "../ui/units";
import { button, problem } from "../ui/controls";
import type { Panel } from "../ui/Panel";

const words = text.stances.carry;

export function createDrawingCarry({ stances }: Pick<Actions, "stances">, addOther: () => void): Panel {
  const says = el("p", { class: "muted small" });
  const note = el("p", { class: "look-here small" });
  const add = button(text.stances.add, addOther, "quiet outlined wide");
  const wrong = problem(() => stances.dismiss());
  const element = el("div", { class: "panel carry" }, el("p", { class: "label" }, words.title), wrong.element, says, add, note);

  function sentence(state: Session): { says: string; note: string } {
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
    update(state: Session): void {
      const told = sentence(state);
      const { other } = state.stances;
      setText(says, told.says);
      show(says, told.says !== "");
      setText(note, told.note);
      show(note, told.note !== "");
      show(add, other === null);
      wrong.set(other ? state.problems.stances : undefined);
    },
  };
}
