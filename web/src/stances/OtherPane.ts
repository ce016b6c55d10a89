// The pane of the stance that waits, and what each pane is called.
import { createSureness } from "../drawing/Sureness";
import type { DrawingSlice } from "../drawing/state";
import type { FitSlice } from "../fit/state";
import type { LandmarksSlice } from "../landmarks/state";
import type { ScanSlice } from "../scan/state";
import { inStance } from "../scan/text";
import { only } from "../store/store";
import { button } from "../ui/controls";
import { el, setText, show } from "../ui/dom";
import type { Panel } from "../ui/Panel";
import { onClick } from "../viewer/clicks";
import type { ViewSlice } from "../viewer/state";
import { errors } from "../viewer/text";
import type { Stage } from "../viewer/Viewer";
import type { StancesActions } from "./actions";
import { createPredictedNote } from "./PredictedNote";
import { isComparing, isPredicted, stanceNames, stanceOf, type StancesSlice } from "./state";
import * as text from "./text";

const words = text.stances;

type Shown = Pick<ScanSlice & LandmarksSlice & FitSlice & DrawingSlice & StancesSlice & ViewSlice, "scan" | "active" | "stance" | "fit" | "drawn" | "stances" | "otherGraphics">;

export function createOtherPane(stances: StancesActions): Panel<Shown> & { caption: HTMLElement; stage: Stage } {
  const canvas = el("canvas", { class: "other-view", tabindex: 0, role: "application" });
  onClick(canvas, () => void stances.work());
  canvas.addEventListener("keydown", ({ key }) => key === "Enter" && void stances.work());
  const overlay = el("div", { class: "overlay is-narrow", "aria-hidden": "true" });
  const name = el("strong", {});
  const following = el("span", { class: "muted small", hidden: true }, words.following);
  const made = createPredictedNote();
  const sureness = { mine: createSureness(), its: createSureness() };
  const head = el("div", { class: "pane-caption" }, name, sureness.its.element, made.badge, following, el("span", { class: "spring" }), made.busy);
  const element = el("section", { class: "other-stage", hidden: true }, canvas, overlay, head, made.note);
  const lost = el("div", { class: "no-graphics", role: "alert", hidden: true }, el("p", {}, errors.graphicsLost), button(errors.loadAgain, () => location.reload(), "outlined"));
  element.append(lost);
  const mine = el("strong", {});
  const caption = el("div", { class: "pane-caption", hidden: true }, mine, sureness.mine.element);
  return {
    element,
    caption,
    stage: { host: element, canvas, overlay },
    select: only("scan", "active", "stance", "fit", "drawn", "stances", "otherGraphics"),
    update(state: Shown): void {
      const isShown = isComparing(state);
      show(element, isShown);
      show(caption, state.scan !== null);
      const [own, other] = stanceNames(state);
      setText(mine, words.here(own));
      sureness.mine.update(state);
      show(lost, state.otherGraphics === "lost");
      if (!isShown) return;
      setText(name, words.here(isPredicted(state.stances.other!) ? inStance(stanceOf(state.stances.other!)) : other));
      show(following, state.stances.isCarrying);
      sureness.its.update(state.stances.other!);
      made.update(state.stances);
      if (element.getAttribute("aria-label") !== words.here(other)) {
        element.setAttribute("aria-label", words.here(other));
        canvas.setAttribute("aria-label", isPredicted(state.stances.other!) ? words.canvas(other) : `${words.canvas(other)} ${words.work}`);
      }
    },
  };
}
