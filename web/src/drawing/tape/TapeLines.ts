// The tape measure on the body: dashed along the skin, each leg's length at its middle, and all of it at the end.
import type { Vector } from "../../api/types";
import type { PageSlice } from "../../store/page";
import { el } from "../../ui/dom";
import { FatLines } from "../../viewer/lines/FatLines";
import type { Surface } from "../../viewer/picking";
import { Pins } from "../../viewer/Pins";
import type { ViewSlice } from "../../viewer/state";
import type { Part, Viewer } from "../../viewer/Viewer";
import { polyline } from "../lines/lines";
import type { DrawingSlice } from "../state";
import type { Tape } from "./tape";
import { tape as words } from "../text";

interface Label {
  readonly at: Vector;
  readonly says: string;
  readonly look: string;
}

export class TapeLines implements Part<Pick<PageSlice & ViewSlice & DrawingSlice, "step" | "overlay" | "drawn">> {
  private readonly lines = new FatLines();
  private readonly labels: Pins<Label>;
  private shown: Tape | null = null;

  constructor(
    private readonly viewer: Viewer,
    private readonly scan: Surface,
  ) {
    viewer.body.add(this.lines.group);
    viewer.beforeFrame.add(() => this.lines.approach(viewer.depthUnits));
    this.labels = new Pins(viewer, scan);
  }

  update({ step, overlay, drawn }: Pick<PageSlice & ViewSlice & DrawingSlice, "step" | "overlay" | "drawn">): void {
    const { palette } = this.viewer;
    this.lines.paint(palette.ink, palette["ink-outline"]);
    const tape = step === "plan" && overlay !== "model" && this.scan.mesh ? drawn.tape : null;
    if (tape === this.shown) return;
    this.shown = tape;
    const legs = tape?.legs ?? [];
    this.lines.set(legs.map(({ points }) => polyline({ points, closed: false, bridged: points.map(() => true) }))); // dashed as a whole: it is no line of the plan
    const labels: Label[] = legs.map((leg) => ({ at: leg.points[Math.floor(leg.points.length / 2)]!, says: words.length(leg.mm, leg.hasHole), look: "" }));
    if (tape && legs.length > 1) labels.push({ at: tape.places.at(-1)!, says: words.total(tape), look: " is-total" });
    this.labels.set(labels.map((label) => [label, label.at]), ({ says, look }) => el("div", { class: `tape-label${look}` }, el("span", {}, says)));
  }
}
