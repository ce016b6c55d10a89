// The corners of the chosen line as marks over the picture, the first click of a line that has no second one yet, and the
// places of the tape.
import { Vector3 } from "three";
import type { Vector } from "../../api/types";
import type { PageSlice } from "../../store/page";
import { el } from "../../ui/dom";
import { metresFromMm } from "../../ui/units";
import { isHidden, type Surface } from "../../viewer/picking";
import type { Part, Viewer } from "../../viewer/Viewer";
import { cornerAt } from "../lines/edits";
import { type DrawingSlice, lineNamed } from "../state";

type Shown = Pick<PageSlice & DrawingSlice, "step" | "drawn">;

const REACH = 12; // pixels from a mark's middle that still hold it: a target of 24

interface Pin {
  readonly element: HTMLElement;
  point: Vector3; // scan's frame, metres
  at: { x: number; y: number } | null;
}

export class CornerPins implements Part<Shown> {
  private pins: Pin[] = [];
  private drawn: unknown = null;
  private held: { corner: number; point: Vector } | null = null;

  constructor(
    private readonly viewer: Viewer,
    private readonly scan: Surface,
  ) {
    viewer.beforeFrame.add(() => this.place());
  }

  update(state: Shown): void {
    const { drawn } = state;
    const line = drawn.tool === "points" ? lineNamed(drawn, drawn.chosen) : drawn.tool === "pen" ? lineNamed(drawn, drawn.open) : null;
    const source = state.step === "plan" ? (drawn.tape ?? line ?? drawn.start) : null;
    if (source !== this.drawn) {
      this.drawn = source;
      for (const pin of this.pins) pin.element.remove();
      const points = source === null ? [] : drawn.tape ? drawn.tape.places : line ? line.corners.map((_, i) => cornerAt(line, i)) : [drawn.start!];
      this.pins = points.map((point, i) => {
        const element = el("div", { class: "corner", "data-corner": i });
        this.viewer.overlay.append(element);
        return { element, point: new Vector3(...point.map(metresFromMm)), at: null };
      });
    }
    this.pins.forEach((pin, i) => pin.element.classList.toggle("is-active", i === drawn.corner));
    this.viewer.invalidate();
  }

  /** The corner under page pixels, or null. */
  at(clientX: number, clientY: number): number | null {
    const box = this.viewer.host.getBoundingClientRect();
    let best: { corner: number; away: number } | null = null;
    this.pins.forEach(({ at }, corner) => {
      const away = at ? Math.hypot(at.x + box.left - clientX, at.y + box.top - clientY) : Infinity;
      if (away <= REACH && away < (best?.away ?? Infinity)) best = { corner, away };
    });
    return (best as { corner: number } | null)?.corner ?? null;
  }

  /** While it is dragged a corner stands elsewhere than the state says; null ends that. */
  hold(corner: number | null, point: Vector | null): void {
    this.held = corner !== null && point ? { corner, point } : null;
    this.viewer.invalidate();
  }

  private place(): void {
    this.pins.forEach((pin, i) => {
      const held = this.held?.corner === i ? this.held.point : null;
      const point = held ? new Vector3(...held.map(metresFromMm)) : pin.point;
      const { x, y } = this.viewer.toScreen(point);
      pin.element.style.transform = `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px)`;
      const hidden = !held && isHidden(this.viewer, this.scan, point, this.scan.normalAt(point));
      pin.element.classList.toggle("is-hidden", hidden);
      pin.at = hidden ? null : { x, y };
    });
  }
}
