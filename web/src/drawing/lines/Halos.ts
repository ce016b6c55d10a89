// How sure the place of each line is, as a band of its true width on the skin: of patterns and of what was carried here.  What a
// hand has drawn on this scan is where it was drawn, and has none.  Beside the pointer stands the number.
import { Color, Vector3 } from "three";
import type { DrawingFile } from "../../api/types";
import type { FittedSurface } from "../../fit/distances/FittedSurface";
import { isAtRest, isUnusable, type Shown } from "../../fit/state";
import type { ScanMesh } from "../../scan/ScanMesh";
import { formatMmWhole, isUnit, metresFromMm, mmFrom } from "../../ui/units";
import type { Banded } from "../../viewer/lines/haloPatch";
import { Halo } from "../../viewer/lines/Halo";
import { pickAt } from "../../viewer/picking";
import { PointerNote } from "../../viewer/PointerNote";
import type { ViewSlice } from "../../viewer/state";
import type { Part, Viewer } from "../../viewer/Viewer";
import { type DrawingSlice, type Layer, layerKey, shownPatterns } from "../state";
import * as text from "../text";
import { ownColour } from "./lines";
import { widthsOf } from "./widths";

type State = Shown & Pick<ViewSlice & DrawingSlice, "overlay" | "drawn">;
type Skin = Pick<ScanMesh | FittedSurface, "mesh" | "bvh" | "normalAt">;
type Line = Pick<DrawingFile["shapes"][number], "name" | "points" | "closed" | "color" | "error_mm" | "line_error_mm"> & { readonly kind?: string };

const NARROWS_MS = { after: 300, for: 600 }; // when the eye is back from where it looked closely

export class Halos implements Part<State> {
  private readonly halo: Halo;
  private shown: unknown[] = [];
  private skin: Skin | null = null;
  private lines: readonly Banded[] = [];
  private share = 1; // of their width, as it is expected
  private times = 1; // their width, on the way to it
  private readonly note: PointerNote;

  constructor(
    private readonly viewer: Viewer,
    private readonly scan: ScanMesh,
    private readonly fitted: FittedSurface,
    canvas: HTMLCanvasElement,
  ) {
    this.halo = new Halo(viewer, "halo of lines", 9);
    this.note = new PointerNote(viewer, canvas, "band-value", false, (x, y) => {
      const hit = this.skin && this.halo.mesh.visible ? pickAt(viewer, this.skin, x, y) : null;
      const at = hit && new Vector3(...hit.point.map(metresFromMm));
      const radius = at && this.halo.radiusAt(at, this.skin!.normalAt(at) ?? new Vector3());
      return radius == null ? null : [text.bands.error(formatMmWhole(mmFrom(radius, "m"))), text.bands.of];
    });
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
    this.note.update();
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
}

function banded(line: Line, mmPerUnit: number, skin: Skin, ink: Color): Banded {
  const points = Float32Array.from(line.points.flatMap((point) => point.map((value) => metresFromMm(value * mmPerUnit))));
  const normals = new Float32Array(points.length);
  for (let i = 0; i < points.length; i += 3) (skin.normalAt(new Vector3().fromArray(points, i)) ?? new Vector3()).toArray(normals, i);
  const colour = ownColour(line.color);
  return { points, normals, radii: Float32Array.from(widthsOf(line), metresFromMm), isClosed: line.closed ?? false, tint: colour === null ? ink : new Color(colour) };
}
