// How sure the place of each line is, as a band of its true width on the skin: of patterns and of what was carried here.  What a
// hand has drawn on this scan is where it was drawn, and has none.  Beside the pointer stands the number.
import { Color, Vector3 } from "three";
import type { DrawingFile } from "../../api/types";
import type { FittedSurface } from "../../fit/distances/FittedSurface";
import { isAtRest, isPosedByHand, type Shown } from "../../fit/state";
import { KNOWN_MM } from "../../fit/verdict";
import type { ScanMesh } from "../../scan/ScanMesh";
import { el, setText } from "../../ui/dom";
import { formatMmWhole, isUnit, metresFromMm, mmFrom } from "../../ui/units";
import type { Banded } from "../../viewer/lines/haloPatch";
import { Halo } from "../../viewer/lines/Halo";
import { onceAFrame } from "../../viewer/onceAFrame";
import { pickAt } from "../../viewer/picking";
import type { ViewSlice } from "../../viewer/state";
import type { Part, Viewer } from "../../viewer/Viewer";
import { type DrawingSlice, type Layer, layerKey, shownPatterns } from "../state";
import * as text from "../text";
import { ownColour } from "./lines";

type State = Shown & Pick<ViewSlice & DrawingSlice, "overlay" | "drawn">;
type Skin = Pick<ScanMesh | FittedSurface, "mesh" | "bvh" | "normalAt">;
type Line = Pick<DrawingFile["shapes"][number], "name" | "points" | "closed" | "color" | "error_mm" | "line_error_mm"> & { readonly kind?: string };

const AWAY = 16; // pixels from the pointer

export class Halos implements Part<State> {
  private readonly halo: Halo;
  private shown: unknown[] = [];
  private skin: Skin | null = null;
  private readonly value = el("strong", {});
  private readonly note = el("span", {}, text.bands.of);
  private readonly element = el("div", { class: "band-value", hidden: true }, this.value, this.note);
  private pointer: PointerEvent | null = null;
  private readonly later = onceAFrame(() => this.place());

  constructor(
    private readonly viewer: Viewer,
    private readonly scan: ScanMesh,
    private readonly fitted: FittedSurface,
    canvas: HTMLCanvasElement,
  ) {
    this.halo = new Halo(viewer);
    viewer.overlay.append(this.element);
    canvas.addEventListener("pointermove", (event) => this.ask(event.buttons === 0 || event.pointerType === "touch" ? event : null));
    canvas.addEventListener("pointerdown", (event) => this.ask(event.pointerType === "touch" ? event : null));
    canvas.addEventListener("pointerleave", () => this.ask(null));
  }

  update(state: State): void {
    const { fit, overlay, drawn } = state;
    const skin: Skin = this.scan.mesh && overlay !== "model" ? this.scan : this.fitted.mesh ? this.fitted : this.scan;
    const isThere = fit !== null && isAtRest(fit) && !isPosedByHand(state);
    const patterns = isThere ? shownPatterns(state) : null;
    const carried = overlay === "model" && isPosedByHand(state) ? null : (drawn.onScan?.carried ?? null);
    const now = [patterns, carried, drawn.hidden, skin.bvh, this.viewer.palette];
    if (now.every((each, i) => each === this.shown[i])) return;
    this.shown = now;
    this.skin = skin;
    const of = (drawing: { readonly unit: string; readonly shapes: readonly Line[] } | null, layer: Layer): Banded[] => {
      const unit = drawing?.unit;
      if (!drawing || !isUnit(unit)) return [];
      return drawing.shapes.filter(({ name, kind }) => kind !== "note" && !drawn.hidden.has(layerKey(layer, name))).map((line) => banded(line, mmFrom(1, unit), skin, this.viewer.palette.ink));
    };
    this.halo.set(skin.bvh ? [...of(patterns, "reference"), ...of(carried, "carried")] : [], skin.mesh?.geometry ?? null);
    this.ask(this.pointer);
  }

  private ask(pointer: PointerEvent | null): void {
    this.pointer = pointer;
    if (pointer || !this.element.hidden) this.later();
  }

  private place(): void {
    const { pointer, viewer, skin } = this;
    const hit = pointer && skin && this.halo.mesh.visible ? pickAt(viewer, skin, pointer.clientX, pointer.clientY) : null;
    const at = hit && new Vector3(...hit.point.map(metresFromMm));
    const radius = at && this.halo.radiusAt(at, skin!.normalAt(at) ?? new Vector3());
    this.element.hidden = radius == null;
    if (radius == null || !pointer) return;
    setText(this.value, text.bands.error(formatMmWhole(mmFrom(radius, "m"))));
    const box = viewer.host.getBoundingClientRect();
    const x = Math.min(pointer.clientX - box.left + AWAY, box.width - this.element.offsetWidth - 8);
    const y = Math.min(pointer.clientY - box.top + AWAY, box.height - this.element.offsetHeight - 8);
    this.element.style.transform = `translate(${x.toFixed(0)}px, ${y.toFixed(0)}px)`;
  }
}

/** What a line's radii, which count in all directions, are to be multiplied with to stand for its line error, across it. */
export function acrossOf({ error_mm, line_error_mm }: Pick<Line, "error_mm" | "line_error_mm">): number {
  const squares = (error_mm ?? []).flatMap((mm) => (mm === null ? [] : [mm * mm]));
  const mean = Math.sqrt(squares.reduce((sum, each) => sum + each, 0) / squares.length);
  return line_error_mm == null || !(mean > 0) ? 1 : line_error_mm / mean;
}

/** Across the line, mm, of each of its points; NaN where it is not known, or so large that nothing is. */
export function widthsOf(line: Pick<Line, "points" | "error_mm" | "line_error_mm">): number[] {
  const across = acrossOf(line);
  return line.points.map((_, i) => {
    const mm = across * (line.error_mm?.[i] ?? NaN);
    return mm <= KNOWN_MM ? mm : NaN;
  });
}

function banded(line: Line, mmPerUnit: number, skin: Skin, ink: Color): Banded {
  const points = Float32Array.from(line.points.flatMap((point) => point.map((value) => metresFromMm(value * mmPerUnit))));
  const normals = new Float32Array(points.length);
  for (let i = 0; i < points.length; i += 3) (skin.normalAt(new Vector3().fromArray(points, i)) ?? new Vector3()).toArray(normals, i);
  const colour = ownColour(line.color);
  return { points, normals, radii: Float32Array.from(widthsOf(line), metresFromMm), isClosed: line.closed ?? false, tint: colour === null ? ink : new Color(colour) };
}
