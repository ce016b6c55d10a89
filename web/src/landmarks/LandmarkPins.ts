// Placed landmarks as numbered marks over the picture: circle = patient's left, square = right, diamond = midline.
import type { ScanSlice } from "../scan/state";
import type { PageSlice } from "../store/page";
import { el } from "../ui/dom";
import { Pins } from "../viewer/Pins";
import type { ViewSlice } from "../viewer/state";
import { marks } from "./marks/text";
import { isMark, sideOf } from "./picks";
import { onlyAgreed } from "./proposals/agreed";
import { type Asked, askedNames, openQuestions } from "./questions/questions";
import type { LandmarksSlice } from "./state";

type Shown = Pick<PageSlice & ViewSlice & ScanSlice & LandmarksSlice, "meta" | "overlay" | "scan" | "picks" | "certain" | "proposals" | "active"> & Pick<Asked, "fit">;

/** With the number that the landmark has in the list. */
export function numberedMark({ meta }: Pick<PageSlice, "meta">, name: string): HTMLElement {
  if (isMark(name)) return el("span", { class: "mark is-mark" }, el("span", {}, marks.sign));
  const number = 1 + (meta?.landmarks.findIndex((entry) => entry.name === name) ?? -1);
  return el("span", { class: `mark side-${sideOf(name)}` }, el("span", {}, String(number)));
}

export class LandmarkPins extends Pins<string> {
  private drawn: unknown = null;

  /** `isFree`: no tool that draws is in the hand; then the marks would be in its way. */
  update(state: Shown, isFree: boolean): void {
    const picks = state.picks.present;
    if (picks !== this.drawn) this.set(Object.entries(picks), (name) => el("div", { class: "pin", "data-landmark": name }, numberedMark(state, name)));
    this.drawn = picks;
    this.show(state.scan !== null && state.overlay !== "model" && isFree);
    const agreed = onlyAgreed(state);
    const asked = askedNames(openQuestions(state));
    this.toggle("is-active", (name) => name === state.active);
    this.toggle("is-agreed", (name) => name in agreed);
    this.toggle("is-asked", (name) => asked.has(name));
  }
}
