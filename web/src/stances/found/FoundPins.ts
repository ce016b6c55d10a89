// Found marks as dashed signs on the body, with the same number on both scans.
import type { ScanSlice } from "../../scan/state";
import type { PageSlice } from "../../store/page";
import { el } from "../../ui/dom";
import { Pins } from "../../viewer/Pins";
import type { ViewSlice } from "../../viewer/state";
import type { Part } from "../../viewer/Viewer";
import { type FoundSlice, placesOn } from "./state";

type Shown = Pick<PageSlice & ViewSlice & ScanSlice & FoundSlice, "overlay" | "scan" | "found">;

export class FoundPins extends Pins<string> implements Part<Shown> {
  update({ overlay, scan, found }: Shown): void {
    this.set(placesOn(found, scan?.info.id), (name) => el("div", { class: "pin is-proposed", "data-found": name }, el("span", { class: "mark is-mark" }, el("span", {}, name.replace(/^m/, "")))));
    this.show(scan !== null && overlay !== "model");
  }
}
