// The pane of the stance that waits, and what each pane is called.
import type { Actions } from "../actions";
import { el, setText, show } from "../dom";
import type { Session } from "../state/session";
import type { OtherStage } from "../stances/OtherView";
import { isComparing, stanceNames } from "../stances/state";
import { text } from "../text";
import { button, iconButton } from "./controls";
import type { Panel } from "./Panel";

const words = text.stances;

export function createOtherPane({ stances }: Pick<Actions, "stances">): Panel & { caption: HTMLElement; stage: OtherStage } {
  const canvas = el("canvas", { class: "other-view", tabindex: 0, role: "application" });
  const overlay = el("div", { class: "overlay is-narrow", "aria-hidden": "true" });
  const name = el("strong", {});
  const work = button(words.workHere, () => void stances.swap(), "outlined");
  const aside = iconButton("close", words.remove(""), () => stances.remove());
  const head = el("div", { class: "pane-caption" }, name, work, el("span", { class: "spring" }), aside);
  const element = el("section", { class: "other-stage", hidden: true }, canvas, overlay, head);
  const mine = el("strong", {});
  const caption = el("div", { class: "pane-caption", hidden: true }, mine, el("span", { class: "muted" }, words.inWork));
  return {
    element,
    caption,
    stage: { host: element, canvas, overlay },
    update(state: Session): void {
      const isShown = isComparing(state);
      show(element, isShown);
      show(caption, isShown);
      if (!isShown) return;
      const [own, other] = stanceNames(state);
      setText(mine, words.here(own));
      setText(name, words.here(other));
      if (element.getAttribute("aria-label") !== words.here(other)) {
        element.setAttribute("aria-label", words.here(other));
        canvas.setAttribute("aria-label", words.canvas(other));
        aside.title = words.remove(other);
        aside.setAttribute("aria-label", words.remove(other));
      }
    },
  };
}
