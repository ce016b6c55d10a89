// The drawing where it belongs: on the model at every iteration, on the scan's own surface when the fit has ended.
import { Vector3 } from "three";
import type { DrawingFile, ModelShape, PlannedShape } from "../../api/types";
import type { FittedSurface } from "../../fit/distances/FittedSurface";
import { hasPattern, shapesOnModel } from "../../fit/modelLines";
import { type FitSlice, isAtRest, isUnusable, modelOf, type Shown, shownPoses } from "../../fit/state";
import type { TorsoModel } from "../../fit/TorsoModel";
import type { ScanMesh } from "../../scan/ScanMesh";
import { mmFrom } from "../../ui/units";
import { allGuessed, FatLines, type Polyline } from "../../viewer/lines/FatLines";
import { smoothed } from "../../viewer/smooth";
import type { ViewSlice } from "../../viewer/state";
import { surfacePosition, type VertexAt } from "../../viewer/lines/surfacePoints";
import type { Part, Viewer } from "../../viewer/Viewer";
import { ownColour, polyline } from "./lines";
import { type DrawingSlice, layerKey, shownPatterns } from "../state";

const LIFT = 0.001; // metres off the skin

type State = Shown & Pick<ViewSlice & FitSlice & DrawingSlice, "overlay" | "drawing" | "drawn">;

export class ReferenceLines implements Part<State> {
  private readonly lines = new FatLines();
  private drawn: unknown[] = [];

  constructor(
    private readonly viewer: Viewer,
    private readonly scan: ScanMesh,
    private readonly torso: TorsoModel,
    private readonly fitted: FittedSurface,
  ) {
    viewer.body.add(this.lines.group);
    viewer.beforeFrame.add(() => this.lines.approach(viewer.depthUnits));
  }

  update(state: State): void {
    const { palette } = this.viewer;
    this.lines.paint(palette.ink, palette["ink-outline"]);
    const fit = state.fit;
    const side = modelOf(state)?.side ?? null;
    const drawing = shownPatterns(state);
    const asked = fit?.drawingName ?? state.drawing;
    const isOnScan = fit !== null && drawing !== null && !isUnusable(state) && isAtRest(fit) && (state.overlay === "model" ? this.fitted.mesh !== null && (this.fitted.mesh.visible || hasPattern(side, asked)) : this.scan.bvh !== null);
    const skin = this.scan.bvh ? this.scan : this.fitted; // a link may show the model alone
    const shapes = shapesOnModel(side, asked);
    const vertexAt = this.torso.vertexAt;
    const isOnModel = !isOnScan && fit !== null && !isUnusable(state) && fit.shown >= 0 && state.overlay !== "scan" && shapes.length > 0 && vertexAt !== null;
    const { hidden } = state.drawn;
    const isOn = ({ name }: { name: string }): boolean => !hidden.has(layerKey("reference", name));
    const source = isOnScan ? [drawing, skin.bvh, hidden] : isOnModel ? [asked, shownPoses(state), hidden] : [];
    if (source.length === this.drawn.length && source.every((each, i) => each === this.drawn[i])) return;
    this.drawn = source;
    if (isOnScan) this.lines.set(onScan(drawing.shapes.filter(isOn), mmFrom(1, drawing.unit), skin).map(smoothed).map(fit.result?.predicted ? allGuessed : (line) => line));
    else if (isOnModel) this.lines.set(onModel(shapes.filter(isOn), this.torso, vertexAt));
    else this.lines.set([]);
    this.viewer.invalidate();
  }
}

interface Skin {
  normalAt(point: Vector3): Vector3 | null;
}

export function onModel(shapes: readonly ModelShape[], torso: TorsoModel, vertexAt: VertexAt): Polyline[] {
  const index = torso.mesh!.geometry.index!.array;
  const position = new Vector3();
  const normal = new Vector3();
  return shapes.map((shape) => {
    const points = new Float32Array(3 * shape.surface_points.length);
    shape.surface_points.forEach((point, i) => {
      surfacePosition(point, index, vertexAt, position, normal);
      position.addScaledVector(normal, LIFT).toArray(points, 3 * i);
    });
    return { points, isClosed: shape.closed, bridged: null, colour: ownColour(shape.color) };
  });
}

function onScan(shapes: readonly (DrawingFile["shapes"][number] | PlannedShape)[], mmPerUnit: number, scan: Skin): Polyline[] {
  return shapes.map((shape) => {
    const line = polyline(shape, mmPerUnit);
    for (let i = 0; i < line.points.length; i += 3) {
      const point = new Vector3().fromArray(line.points, i);
      point.addScaledVector(scan.normalAt(point) ?? new Vector3(), LIFT).toArray(line.points, i);
    }
    return line;
  });
}
