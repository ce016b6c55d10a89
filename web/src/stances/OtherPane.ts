// The pane of the stance that waits, and what each pane is called.
import type { Actions } from "../app/actions";
import { el, setText, show } from "../ui/dom";
import type { Session } from "../app/session";
import type { OtherStage } from "./OtherView";
import { isComparing, stanceNames } from "./state";
import { text } from "../ui/text";
import { button, iconButton } from "../ui/controls";
import type { Panel } from "../ui/Panel";

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
