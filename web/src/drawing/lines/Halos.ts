// How sure the place of each line is, as a band of its true width on the skin: of patterns and of what was carried here.  What a
// hand has drawn on this scan is where it was drawn, and has none.  Beside the pointer stands the number.
import { Color, Vector3 } from "three";
import type { DrawingFile } from "../../api/types";
import type { FittedSurface } from "../../fit/distances/FittedSurface";
import { isAtRest, isUnusable, type Shown } from "../../fit/state";
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
import { widthsOf } from "./widths";

type State = Shown & Pick<ViewSlice & DrawingSlice, "overlay" | "drawn">;
type Skin = Pick<ScanMesh | FittedSurface, "mesh" | "bvh" | "normalAt">;
type Line = Pick<DrawingFile["shapes"][number], "name" | "points" | "closed" | "color" | "error_mm" | "line_error_mm"> & { readonly kind?: string };

const AWAY = 16; // pixels from the pointer
const NARROWS_MS = { after: 300, for: 600 }; // when the eye is back from where it looked closely

export class Halos implements Part<State> {
  private readonly halo: Halo;
  private shown: unknown[] = [];
  private skin: Skin | null = null;
  private lines: readonly Banded[] = [];
  private share = 1; // of their width, as it is expected
  private times = 1; // their width, on the way to it
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
    this.halo = new Halo(viewer, "halo of lines", 9);
    viewer.overlay.append(this.element);
    canvas.addEventListener("pointermove", (event) => this.ask(event.buttons === 0 || event.pointerType === "touch" ? event : null));
    canvas.addEventListener("pointerdown", (event) => this.ask(event.pointerType === "touch" ? event : null));
    canvas.addEventListener("pointerleave", () => this.ask(null));
  }

  /** `share` of their width is what is expected of points that are being checked. */
  update(state: State, share = 1): void {
    const { fit, overlay, drawn } = state;
    const skin: Skin = this.scan.mesh && overlay !== "model" ? this.scan : this.fitted.mesh ? this.fitted : this.scan;
    const isThere = fit !== null && isAtRest(fit) && !isUnusable(state);
    const patterns = isThere ? shownPatterns(state) : null;
    const carried = drawn.onScan?.carried ?? null;
    const now = [patterns, carried, drawn.hidden, skin.bvh, this.viewer.palette];
    if (now.every((each, i) => each === this.shown[i])) {
      if (share === this.share) return;
      this.share = share;
      return this.write();
    }
    this.shown = now;
    this.share = share;
    this.skin = skin;
    const of = (drawing: { readonly unit: string; readonly shapes: readonly Line[] } | null, layer: Layer): Banded[] => {
      const unit = drawing?.unit;
      if (!drawing || !isUnit(unit)) return [];
      return drawing.shapes.filter(({ name, kind }) => kind !== "note" && !drawn.hidden.has(layerKey(layer, name))).map((line) => banded(line, mmFrom(1, unit), skin, this.viewer.palette.ink));
    };
    this.lines = skin.bvh ? [...of(patterns, "reference"), ...of(carried, "carried")] : [];
    this.write();
    this.ask(this.pointer);
  }

  /** They are seen to narrow from so many times their width to their own. */
  narrow(times: number): void {
    const begins = performance.now() + NARROWS_MS.after;
    const step = (now: number): void => {
      const left = 1 - Math.min(1, Math.max(0, (now - begins) / NARROWS_MS.for));
      this.times = 1 + (times - 1) * left ** 3;
      this.write();
      if (left > 0) requestAnimationFrame(step);
    };
    step(begins);
  }

  private write(): void {
    const by = this.share * this.times;
    this.halo.set(by === 1 ? this.lines : this.lines.map((line) => ({ ...line, radii: line.radii.map((radius) => by * radius) })), this.skin?.mesh?.geometry ?? null);
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

function banded(line: Line, mmPerUnit: number, skin: Skin, ink: Color): Banded {
  const points = Float32Array.from(line.points.flatMap((point) => point.map((value) => metresFromMm(value * mmPerUnit))));
  const normals = new Float32Array(points.length);
  for (let i = 0; i < points.length; i += 3) (skin.normalAt(new Vector3().fromArray(points, i)) ?? new Vector3()).toArray(normals, i);
  const colour = ownColour(line.color);
  return { points, normals, radii: Float32Array.from(widthsOf(line), metresFromMm), isClosed: line.closed ?? false, tint: colour === null ? ink : new Color(colour) };
}
