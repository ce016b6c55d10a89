// The instruction beside the body while a landmark is being placed: what, on which side, how to find it, a picture.
import type { PageSlice } from "../store/page";
import { only } from "../store/store";
import { button } from "../ui/controls";
import { el, setText, show } from "../ui/dom";
import type { Panel } from "../ui/Panel";
import type { LandmarkActions } from "./actions";
import type { MarksSlice } from "./marks/marks";
import { marks } from "./marks/text";
import { isMark, markCalled, plainLabel, sideOf } from "./picks";
import { isFelt, onlyAgreed } from "./proposals/agreed";
import { errorOf, openProposals } from "./proposals/proposals";
import type { LandmarksSlice } from "./state";
import * as text from "./text";

type Shown = Pick<PageSlice & LandmarksSlice & MarksSlice, "meta" | "active" | "picks" | "certain" | "proposals" | "beside">;

export interface GuideCard extends Panel<Shown> {
  readonly canvas: HTMLCanvasElement;
  readonly light: HTMLElement;
}

export function createGuideCard(actions: LandmarkActions): GuideCard {
  const canvas = el("canvas", { class: "model-picture", role: "img", "aria-label": text.landmarks.guideCaption });
  const light = el("span", { class: "lit-point", hidden: true });
  const name = el("h3", {});
  const side = el("span", { class: "chip" });
  const latin = el("p", { class: "latin muted" });
  const definition = el("p", {});
  const skip = button(text.landmarks.skip, () => actions.skip(), "quiet outlined");
  const take = button(text.proposals.take, () => actions.confirmWanted(), "outlined take", "check");
  const closely = el("p", { class: "muted small" });
  const stop = button(text.landmarks.stop, () => actions.want(null));
  const picture = el("div", { class: "picture" }, canvas, light);
  const element = el(
    "section",
    { class: "guide", hidden: true, "aria-live": "polite" },
    el("h2", {}, text.landmarks.guideTitle),
    picture,
    el("div", { class: "guide-words" }, el("div", { class: "guide-head" }, name, side), latin, definition),
    closely,
    take,
    el("div", { class: "buttons" }, skip, stop),
    el("p", { class: "muted small" }, text.landmarks.how),
  );
  return {
    element,
    canvas,
    light,
    select: only("meta", "active", "picks", "certain", "proposals", "beside"),
    update(state: Shown): void {
      const wanted = state.meta?.landmarks.find((entry) => entry.name === state.active);
      const mark = state.active !== null && isMark(state.active) ? state.active : null;
      show(element, wanted !== undefined || mark !== null);
      for (const each of [picture, side, latin, skip]) show(each, mark === null);
      if (mark !== null) {
        setText(name, markCalled(mark));
        setText(definition, !(mark in state.beside) ? marks.how : state.beside[mark] ? marks.pair : marks.pairUnknown);
        for (const each of [take, closely]) show(each, false);
        return;
      }
      if (!wanted) return;
      setText(name, plainLabel(wanted.label));
      const where = sideOf(wanted.name);
      setText(side, text.landmarks.sides[where]);
      side.className = `chip side-${where}`;
      light.className = `lit-point side-${where}`;
      const proposal = openProposals(state.proposals, state.picks.present).find((each) => each.name === wanted.name);
      const isAgreed = wanted.name in onlyAgreed(state);
      show(take, proposal !== undefined || (isAgreed && !isFelt(wanted.name)));
      setText(take.querySelector("span")!, isAgreed ? text.proposals.looked : text.proposals.take);
      show(closely, proposal !== undefined || isAgreed);
      setText(closely, isFelt(wanted.name) ? text.proposals.felt : text.proposals.nearer);
      take.title = isAgreed ? text.proposals.nearer : "";
      if (proposal) take.title = text.proposals.errorHint(errorOf(proposal) ?? text.proposals.unknown, proposal.reason);
      setText(latin, wanted.latin);
      setText(definition, wanted.definition);
    },
  };
}
