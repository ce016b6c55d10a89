// The distance under the pointer, beside it, while the model is coloured by its distances.
import { el, setText } from "../../ui/dom";
import { formatSignedMm } from "../../ui/units";
import { surfaceAt } from "../../viewer/picking";
import type { Part, Viewer } from "../../viewer/Viewer";
import { distanceWithin, SCANNER_MM } from "./distances";
import type { FittedSurface } from "./FittedSurface";
import type { FitSlice } from "../state";
import * as text from "../text";
import { onceAFrame } from "../../viewer/onceAFrame";

type Shown = Pick<FitSlice, "fit" | "showDistances">;

const AWAY = 16; // pixels from the pointer

export class HoverValue implements Part<Shown> {
  private readonly value = el("strong", {});
  private readonly note = el("span", {});
  private readonly element = el("div", { class: "hover-value", hidden: true }, this.value, this.note);
  private distances: Float32Array | null = null;
  private pointer: PointerEvent | null = null;
  private readonly later = onceAFrame(() => this.place());

  constructor(
    private readonly viewer: Viewer,
    private readonly surface: FittedSurface,
    canvas: HTMLCanvasElement,
  ) {
    viewer.overlay.append(this.element);
    canvas.addEventListener("pointermove", (event) => this.ask(event.buttons === 0 || event.pointerType === "touch" ? event : null));
    canvas.addEventListener("pointerdown", (event) => this.ask(event.pointerType === "touch" ? event : null));
    canvas.addEventListener("pointerleave", () => this.ask(null));
  }

  update(state: Shown): void {
    this.distances = state.showDistances ? (state.fit?.distances ?? null) : null;
    this.ask(this.pointer);
  }

  private ask(pointer: PointerEvent | null): void {
    this.pointer = pointer;
    if (pointer || !this.element.hidden) this.later();
  }

  private place(): void {
    const { pointer, distances } = this;
    const hit = pointer && distances ? surfaceAt(this.viewer, this.surface.mesh, pointer.clientX, pointer.clientY) : null;
    this.element.hidden = !hit;
    if (!hit) return;
    const mm = distanceWithin(distances!, hit.corners, hit.weights);
    setText(this.value, mm === null ? "" : text.distances.hover(formatSignedMm(mm)));
    setText(this.note, noteOf(mm));
    const box = this.viewer.host.getBoundingClientRect();
    const x = Math.min(pointer!.clientX - box.left + AWAY, box.width - this.element.offsetWidth - 8);
    const y = Math.max(pointer!.clientY - box.top - this.element.offsetHeight - AWAY / 2, 8);
    this.element.style.transform = `translate(${x.toFixed(0)}px, ${y.toFixed(0)}px)`;
  }
}

function noteOf(mm: number | null): string {
  if (mm === null) return text.distances.hoverNone;
  if (Math.abs(mm) <= SCANNER_MM) return text.distances.hoverScanner;
  return mm < 0 ? text.distances.hoverInside : text.distances.hoverOutside;
}
