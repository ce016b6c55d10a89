// How sure the place of each line is, as a soft band on the skin around it: the reference drawing's and that of what was
// carried here.  Beside the pointer stands the number.
import { BufferAttribute, BufferGeometry, type Color, Mesh, MeshBasicMaterial, Vector3 } from "three";
import type { DrawingFile } from "../../api/types";
import type { FittedSurface } from "../../fit/distances/FittedSurface";
import { isAtRest, isPosedByHand, type Shown } from "../../fit/state";
import type { ScanMesh } from "../../scan/ScanMesh";
import { el, setText } from "../../ui/dom";
import { formatMmWhole, isUnit, metresFromMm, mmFrom } from "../../ui/units";
import { pickAt } from "../../viewer/picking";
import type { ViewSlice } from "../../viewer/state";
import type { Part, Viewer } from "../../viewer/Viewer";
import { ErrorIndex, errorBand, type ErrorPoints } from "./errorBand";
import { BANDS, type DrawingSlice, type Layer, layerKey, shownPatterns } from "../state";
import * as text from "../text";
import { onceAFrame } from "../../viewer/onceAFrame";

type State = Shown & Pick<ViewSlice & DrawingSlice, "overlay" | "drawn">;
type Drawing = Pick<DrawingFile, "unit"> & { readonly shapes: readonly Pick<DrawingFile["shapes"][number], "name" | "points" | "error_mm" | "line_error_mm">[] };

const STRENGTH = 0.45; // opacity
const SOFT = 0.2; // share of the band over which it dies out
const TOWARDS_EYE = 0.006; // metres: over the noise of scan and fit, under the lines
const AWAY = 16; // pixels from the pointer

export class ErrorBands implements Part<State> {
  private readonly layers = { reference: new BandOnSkin("reference"), carried: new BandOnSkin("carried") };
  private readonly value = el("strong", {});
  private readonly note = el("span", {});
  private readonly element = el("div", { class: "band-value", hidden: true }, this.value, this.note);
  private pointer: PointerEvent | null = null;
  private readonly later = onceAFrame(() => this.place());

  constructor(
    private readonly viewer: Viewer,
    private readonly scan: ScanMesh,
    private readonly fitted: FittedSurface,
    canvas: HTMLCanvasElement,
  ) {
    for (const each of Object.values(this.layers)) viewer.body.add(each.mesh);
    viewer.beforeFrame.add(() => {
      for (const each of Object.values(this.layers)) each.mesh.material.polygonOffsetUnits = -TOWARDS_EYE * viewer.depthUnits;
    });
    viewer.overlay.append(this.element);
    canvas.addEventListener("pointermove", (event) => this.ask(event.buttons === 0 || event.pointerType === "touch" ? event : null));
    canvas.addEventListener("pointerdown", (event) => this.ask(event.pointerType === "touch" ? event : null));
    canvas.addEventListener("pointerleave", () => this.ask(null));
  }

  update(state: State): void {
    const { palette } = this.viewer;
    const { fit, overlay } = state;
    const skin = this.skin(state);
    const isOn = !state.drawn.hidden.has(BANDS);
    const isThere = fit !== null && isAtRest(fit) && !isPosedByHand(state);
    this.layers.reference.update(isThere ? shownPatterns(state) : null, skin, state.drawn.hidden, palette.band, isOn);
    const carried = !(overlay === "model" && isPosedByHand(state)) ? (state.drawn.onScan?.carried ?? null) : null;
    this.layers.carried.update(carried, skin, state.drawn.hidden, palette.band, isOn);
    this.ask(this.pointer);
    this.viewer.invalidate();
  }

  private skin({ overlay }: Pick<ViewSlice, "overlay">): ScanMesh | FittedSurface {
    return this.scan.mesh && overlay !== "model" ? this.scan : this.fitted.mesh ? this.fitted : this.scan;
  }

  private ask(pointer: PointerEvent | null): void {
    this.pointer = pointer;
    if (pointer || !this.element.hidden) this.later();
  }

  private place(): void {
    const { pointer, viewer } = this;
    const found = pointer && Object.values(this.layers).flatMap((each) => each.at(viewer, pointer) ?? [])[0];
    this.element.hidden = !found;
    if (!found) return;
    setText(this.value, text.bands.error(formatMmWhole(found.mm)));
    setText(this.note, text.bands.of);
    const box = viewer.host.getBoundingClientRect();
    const x = Math.min(pointer.clientX - box.left + AWAY, box.width - this.element.offsetWidth - 8);
    const y = Math.min(pointer.clientY - box.top + AWAY, box.height - this.element.offsetHeight - 8);
    this.element.style.transform = `translate(${x.toFixed(0)}px, ${y.toFixed(0)}px)`;
  }
}

/** One layer's band; made anew when its lines or the skin change. */
class BandOnSkin {
  readonly mesh: Mesh<BufferGeometry, MeshBasicMaterial>;
  private shown: unknown[] = [];
  private points: ErrorPoints = noPoints;
  private index: ErrorIndex | null = null;
  private skin: ScanMesh | FittedSurface | null = null;

  constructor(private readonly layer: Extract<Layer, "reference" | "carried">) {
    this.mesh = new Mesh(new BufferGeometry(), material(STRENGTH));
    this.mesh.renderOrder = 9; // after the translucent model, before the lines
    this.mesh.visible = false;
    this.mesh.raycast = () => undefined;
  }

  update(drawing: Drawing | null, skin: ScanMesh | FittedSurface, hidden: ReadonlySet<string>, colour: Color, isShown: boolean): void {
    this.mesh.material.color.copy(colour);
    const now = [drawing, skin.mesh, hidden, isShown];
    if (now.every((each, i) => each === this.shown[i])) return;
    this.shown = now;
    this.skin = skin;
    const lines = drawing && skin.mesh && isUnit(drawing.unit) ? drawing.shapes.filter(({ name }) => !hidden.has(layerKey(this.layer, name))) : [];
    this.points = drawing ? pointsOf(lines, mmFrom(1, drawing.unit), skin) : noPoints;
    this.index = this.points.errors.length > 0 ? new ErrorIndex(this.points) : null;
    this.mesh.visible = this.index !== null && isShown;
    this.mesh.geometry.dispose();
    this.mesh.geometry = new BufferGeometry();
    if (!this.index || !isShown) return;
    const { attributes, index } = skin.mesh!.geometry;
    const band = errorBand({ position: attributes.position!.array, normal: attributes.normal!.array, index: index!.array }, this.index);
    this.mesh.geometry.setAttribute("position", new BufferAttribute(band.position, 3));
    this.mesh.geometry.setAttribute("share", new BufferAttribute(band.share, 1));
  }

  /** The error of the line in whose band the pointer is. */
  at(viewer: Viewer, { clientX, clientY }: PointerEvent): { mm: number } | null {
    if (!this.index || !this.skin) return null;
    const hit = pickAt(viewer, this.skin, clientX, clientY);
    if (!hit) return null;
    const place = new Vector3(...hit.point.map(metresFromMm) as [number, number, number]);
    const normal = this.skin.normalAt(place) ?? new Vector3();
    const found = this.index.nearest(...place.toArray(), ...normal.toArray());
    return found && found.share < 1 ? { mm: mmFrom(this.points.errors[found.point]!, "m") } : null;
  }
}

const noPoints: ErrorPoints = { points: new Float32Array(), normals: new Float32Array(), errors: new Float32Array() };

/** What a line's radii, which count in all directions, are to be multiplied with to stand for its line error, across it. */
export function acrossOf({ error_mm, line_error_mm }: Pick<DrawingFile["shapes"][number], "error_mm" | "line_error_mm">): number {
  const squares = (error_mm ?? []).flatMap((mm) => (mm === null ? [] : [mm * mm]));
  const mean = Math.sqrt(squares.reduce((sum, each) => sum + each, 0) / squares.length);
  return line_error_mm == null || !(mean > 0) ? 1 : line_error_mm / mean;
}

function pointsOf(lines: Drawing["shapes"], mmPerUnit: number, skin: ScanMesh | FittedSurface): ErrorPoints {
  const points: number[] = [];
  const normals: number[] = [];
  const errors: number[] = [];
  for (const line of lines) {
    const share = acrossOf(line);
    line.points.forEach((point, i) => {
      const error = share * (line.error_mm?.[i] ?? 0);
      if (!(error > 0)) return;
      const at = point.map((value) => metresFromMm(value * mmPerUnit)) as [number, number, number];
      points.push(...at);
      normals.push(...(skin.normalAt(new Vector3(...at)) ?? new Vector3()).toArray());
      errors.push(metresFromMm(error));
    });
  }
  return { points: new Float32Array(points), normals: new Float32Array(normals), errors: new Float32Array(errors) };
}

/** Even up to the last part of the band, where it dies out: its end is no line. */
function material(opacity: number): MeshBasicMaterial {
  const made = new MeshBasicMaterial({ transparent: true, opacity, depthWrite: false, polygonOffset: true });
  made.onBeforeCompile = (shader) => {
    shader.vertexShader = shader.vertexShader
      .replace("#include <common>", "#include <common>\nattribute float share;\nvarying float vShare;")
      .replace("#include <begin_vertex>", "#include <begin_vertex>\nvShare = share;");
    shader.fragmentShader = shader.fragmentShader
      .replace("#include <common>", "#include <common>\nvarying float vShare;")
      .replace("#include <color_fragment>", `#include <color_fragment>\ndiffuseColor.a *= 1.0 - smoothstep(${(1 - SOFT).toFixed(2)}, 1.0, vShare);`);
  };
  return made;
}
