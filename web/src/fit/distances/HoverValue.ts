// The distance under the pointer, beside it, while the model is coloured by its distances.
import { formatSignedMm } from "../../ui/units";
import { surfaceAt } from "../../viewer/picking";
import { PointerNote } from "../../viewer/PointerNote";
import type { Part, Viewer } from "../../viewer/Viewer";
import { distanceWithin, SCANNER_MM } from "./distances";
import type { FittedSurface } from "./FittedSurface";
import type { FitSlice } from "../state";
import * as text from "../text";

type Shown = Pick<FitSlice, "fit" | "showDistances">;

export class HoverValue implements Part<Shown> {
  private readonly note: PointerNote;
  private distances: Float32Array | null = null;

  constructor(viewer: Viewer, surface: FittedSurface, canvas: HTMLCanvasElement) {
    this.note = new PointerNote(viewer, canvas, "hover-value", true, (x, y) => {
      const hit = this.distances && surfaceAt(viewer, surface.mesh, x, y);
      const mm = hit && distanceWithin(this.distances!, hit.corners, hit.weights);
      return hit && [mm === null ? "" : text.distances.hover(formatSignedMm(mm)), noteOf(mm)];
    });
  }

  update(state: Shown): void {
    this.distances = state.showDistances ? (state.fit?.distances ?? null) : null;
    this.note.update();
  }
}

function noteOf(mm: number | null): string {
  if (mm === null) return text.distances.hoverNone;
  if (Math.abs(mm) <= SCANNER_MM) return text.distances.hoverScanner;
  return mm < 0 ? text.distances.hoverInside : text.distances.hoverOutside;
}
