// The ends of a measured length that are no landmarks.
import type { Vector } from "../../api/types";
import type { ScanSlice } from "../../scan/state";
import { el } from "../../ui/dom";
import { Pins } from "../../viewer/Pins";
import type { ViewSlice } from "../../viewer/state";
import { marks } from "../marks/text";
import type { RulerSlice, Side } from "./ruler";

type Shown = Pick<ViewSlice & ScanSlice & RulerSlice, "overlay" | "scan" | "ruler">;

export class RulerPins extends Pins<Side> {
  update({ ruler, scan, overlay }: Shown): void {
    const clicked = Object.entries(ruler).filter((end): end is [Side, Vector] => Array.isArray(end[1]));
    this.set(clicked, (side) => el("div", { class: "pin is-ruler", "data-ruler": side }, el("span", { class: "mark is-mark" }, el("span", {}, marks.sign))));
    this.show(scan !== null && overlay !== "model");
  }
}
