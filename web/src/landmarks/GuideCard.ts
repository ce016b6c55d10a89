// The instruction beside the body while a landmark is being placed: what, on which side, how to find it, a picture.
import type { Actions } from "../app/actions";
import { el, setText, show } from "../ui/dom";
import { plainLabel, sideOf } from "./picks";
import { expectedErrorMm, ghostsOf } from "./proposals";
import type { Session } from "../app/session";
import { text } from "../ui/text";
import { formatMmWhole } from "../ui/units";
import { button } from "../ui/controls";
import type { Panel } from "../ui/Panel";

export interface GuideCard extends Panel {
  readonly canvas: HTMLCanvasElement;
  readonly light: HTMLElement;
}

export function createGuideCard(actions: Actions): GuideCard {
  const canvas = el("canvas", { class: "model-picture", role: "img", "aria-label": text.landmarks.guideCaption });
  const light = el("span", { class: "lit-point", hidden: true });
  const name = el("h3", {});
  const side = el("span", { class: "chip" });
  const latin = el("p", { class: "latin muted" });
  const definition = el("p", {});
  const skip = button(text.landmarks.skip, () => actions.landmarks.skip(), "quiet outlined");
  const take = button(text.proposals.take, () => actions.landmarks.confirmWanted(), "outlined take", "check");
  const stop = button(text.landmarks.stop, () => actions.landmarks.want(null));
  const element = el(
    "section",
    { class: "guide", hidden: true, "aria-live": "polite" },
    el("h2", {}, text.landmarks.guideTitle),
    el("div", { class: "picture" }, canvas, light),
    el("div", { class: "guide-words" }, el("div", { class: "guide-head" }, name, side), latin, definition),
    take,
    el("div", { class: "buttons" }, skip, stop),
    el("p", { class: "muted small" }, text.landmarks.how),
  );
  return {
    element,
    canvas,
    light,
    update(state: Session): void {
      const wanted = state.meta?.landmarks.find((entry) => entry.name === state.active);
      show(element, wanted !== undefined);
      if (!wanted) return;
      setText(name, plainLabel(wanted.label));
      const where = sideOf(wanted.name);
      setText(side, text.landmarks.sides[where]);
      side.className = `chip side-${where}`;
      light.className = `lit-point side-${where}`;
      const ghost = ghostsOf(state.proposals, state.picks.present).find((each) => each.name === wanted.name);
      show(take, ghost !== undefined);
      if (ghost) take.title = text.proposals.errorHint(formatMmWhole(expectedErrorMm(ghost.confidence)));
      setText(latin, wanted.latin);
      setText(definition, wanted.definition);
    },
  };
}
