// The tape measure on the body: dashed along the skin, each leg's length at its middle, and all of it at the end.
import { Vector3 } from "three";
import type { Vector } from "../../api/types";
import type { PageSlice } from "../../store/page";
import { el } from "../../ui/dom";
import { metresFromMm } from "../../ui/units";
import { FatLines } from "../../viewer/lines/FatLines";
import { isHidden, type Surface } from "../../viewer/picking";
import type { ViewSlice } from "../../viewer/state";
import type { Part, Viewer } from "../../viewer/Viewer";
import { polyline } from "../lines/lines";
import type { DrawingSlice } from "../state";
import type { Tape } from "./tape";
import { tape as words } from "../text";

interface Label {
  readonly element: HTMLElement;
  readonly at: Vector3; // scan's frame, metres
}

export class TapeLines implements Part<Pick<PageSlice & ViewSlice & DrawingSlice, "step" | "overlay" | "drawn">> {
  private readonly lines = new FatLines();
  private labels: Label[] = [];
  private shown: Tape | null = null;

  constructor(
    private readonly viewer: Viewer,
    private readonly scan: Surface,
  ) {
    viewer.body.add(this.lines.group);
    viewer.beforeFrame.add(() => {
      this.lines.approach(viewer.depthUnits);
      this.place();
    });
  }

  update({ step, overlay, drawn }: Pick<PageSlice & ViewSlice & DrawingSlice, "step" | "overlay" | "drawn">): void {
    const { palette } = this.viewer;
    this.lines.paint(palette.ink, palette["ink-outline"]);
    const tape = step === "plan" && overlay !== "model" && this.scan.mesh ? drawn.tape : null;
    if (tape === this.shown) return;
    this.shown = tape;
    const legs = tape?.legs ?? [];
    this.lines.set(legs.map(({ points }) => polyline({ points, closed: false, bridged: points.map(() => true) }))); // dashed as a whole: it is no line of the plan
    for (const { element } of this.labels) element.remove();
    this.labels = legs.map((leg) => this.label(leg.points[Math.floor(leg.points.length / 2)]!, words.length(leg.mm, leg.hasHole), "tape-label"));
    if (tape && legs.length > 1) this.labels.push(this.label(tape.places.at(-1)!, words.total(tape), "tape-label is-total"));
    this.viewer.invalidate();
  }

  private label(at: Vector, says: string, look: string): Label {
    const element = el("div", { class: look }, el("span", {}, says));
    this.viewer.overlay.append(element);
    return { element, at: new Vector3(...at.map(metresFromMm)) };
  }

  private place(): void {
    for (const { element, at } of this.labels) {
      const { x, y } = this.viewer.toScreen(at);
      element.style.transform = `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px)`;
      element.classList.toggle("is-hidden", isHidden(this.viewer, this.scan, at, this.scan.normalAt(at)));
    }
  }
}
