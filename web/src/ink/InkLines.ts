// The found lines on the body: pale and dashed, as long as nobody has accepted them; the one that is pointed at is whole.
// They are seen where their list is: landmarks are placed on the ink itself, and not on what lies over it.
import { polyline } from "../drawing/lines";
import type { ScanSlice } from "../scan/state";
import type { PageSlice } from "../store/page";
import { FatLines } from "../viewer/FatLines";
import type { Part, Viewer } from "../viewer/Viewer";
import { foundOn, type InkSlice } from "./state";

type Shown = Pick<PageSlice & ScanSlice & InkSlice, "step" | "scan" | "ink" | "inkPointed">;

const NONE: ReturnType<typeof foundOn> = [];

export class InkLines implements Part<Shown> {
  private readonly lines = new FatLines();
  private drawn: unknown[] = [];

  constructor(private readonly viewer: Viewer) {
    viewer.body.add(this.lines.group);
    viewer.beforeFrame.add(() => this.lines.approach(viewer.depthUnits));
  }

  update({ step, scan, ink, inkPointed }: Shown): void {
    const { palette } = this.viewer;
    this.lines.paint(palette.ink, palette["ink-outline"]);
    const found = step === "scan" || step === "drawing" ? foundOn(ink, scan?.info.id) : NONE;
    const now = [found, inkPointed];
    if (now.every((each, i) => each === this.drawn[i])) return;
    this.drawn = now;
    this.lines.set(found.map(({ name, points, closed, color }) => polyline({ points, closed, color, bridged: points.map(() => name !== inkPointed) })));
    this.viewer.invalidate();
  }
}
