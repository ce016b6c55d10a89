// The surgeon's lines on the scan: in their colour, else black with a white outline; dashed over holes.  What was carried here from the other
// stance is drawn the same way, and dashed on a body that nobody has scanned.
import type { Vector } from "../../api/types";
import type { FitSlice } from "../../fit/state";
import { isUnit, mmFrom } from "../../ui/units";
import { allGuessed, FatLines, type Polyline } from "../../viewer/lines/FatLines";
import type { Surface } from "../../viewer/picking";
import { smoothed } from "../../viewer/smooth";
import type { Part, Viewer } from "../../viewer/Viewer";
import { bridgedAt } from "./edits";
import { type OwnLine, polyline } from "./lines";
import { type DrawingSlice, type DrawnState, type Layer, layerKey } from "../state";
import { BRIDGE_MM } from "./strokes";

type Shown = Pick<FitSlice & DrawingSlice, "fit" | "drawn">;

export class OwnLines implements Part<Shown> {
  private readonly own = new FatLines();
  private readonly carried = new FatLines();
  private readonly live = new FatLines(); // apart, so that a moving hand writes one line and not all
  private drawn: unknown[] = [];
  private state: DrawnState | null = null;
  private isShown = false;
  private isPredicted = false;
  private instead: string | null = null;

  constructor(
    private readonly viewer: Viewer,
    private readonly scan: Pick<Surface, "mesh">,
  ) {
    viewer.body.add(this.own.group, this.carried.group, this.live.group);
    viewer.beforeFrame.add(() => {
      for (const each of [this.own, this.carried, this.live]) each.approach(viewer.depthUnits);
    });
  }

  update(state: Shown): void {
    const { palette } = this.viewer;
    for (const each of [this.own, this.carried, this.live]) each.paint(palette.ink, palette["ink-outline"]);
    this.state = state.drawn;
    this.isPredicted = state.fit?.result?.predicted ?? false;
    this.isShown = this.scan.mesh !== null;
    const { lines, hidden, onScan } = state.drawn;
    const now = [lines.present, hidden, onScan, this.isShown];
    if (now.every((each, i) => each === this.drawn[i])) return;
    this.drawn = now;
    this.write();
  }

  /** While the pen moves: what it has drawn so far. */
  showStrokes(strokes: readonly (readonly Vector[])[], color: string): void {
    this.live.set(this.isShown ? strokes.map((points) => polyline({ points, closed: false, bridged: null, color })) : []);
    this.viewer.invalidate();
  }

  /** While the hand moves: a line that the state does not know yet, instead of the one that it changes. */
  show(line: Pick<OwnLine, "points" | "closed" | "color" | "bridged"> | null, instead: string | null = null): void {
    this.live.set(line && this.isShown ? [laid(line)] : []);
    const isOther = (line ? instead : null) !== this.instead;
    this.instead = line ? instead : null;
    if (isOther) this.write();
    this.viewer.invalidate();
  }

  private write(): void {
    const { state, instead } = this;
    if (!state) return;
    const isOn = (layer: Layer, name: string): boolean => !state.hidden.has(layerKey(layer, name));
    const own = state.lines.present.filter(({ name }) => isOn("own", name) && name !== instead);
    this.own.set(this.isShown ? own.map(laid) : []);
    const unit = state.onScan?.carried.unit;
    const carried = state.onScan?.carried.shapes.filter(({ name }) => isOn("carried", name)) ?? [];
    const laidHere = this.isShown && isUnit(unit) ? carried.map((shape) => smoothed(polyline(shape, mmFrom(1, unit)))) : [];
    this.carried.set(this.isPredicted ? laidHere.map(allGuessed) : laidHere);
    this.viewer.invalidate();
  }
}

const laid = ({ points, closed, color, bridged }: Pick<OwnLine, "points" | "closed" | "color" | "bridged">): Polyline => polyline({ closed, color, ...bridgedAt(points, closed, BRIDGE_MM, bridged) });
