// The found lines on the body: pale and dashed, as long as nobody has accepted them; the one that is pointed at is whole.
// They are seen where their list is: landmarks are placed on the ink itself, and not on what lies over it.
import { polyline } from "../drawing/lines/lines";
import type { DrawingSlice } from "../drawing/state";
import { cropsOf } from "../scan/crop";
import type { ScanSlice } from "../scan/state";
import type { PageSlice } from "../store/page";
import { FatLines } from "../viewer/lines/FatLines";
import type { Part, Viewer } from "../viewer/Viewer";
import { type InkSlice, openLines } from "./state";

type Shown = Pick<PageSlice & ScanSlice & DrawingSlice & InkSlice, "step" | "scan" | "drawn" | "ink" | "inkPointed">;

export class InkLines implements Part<Shown> {
  private readonly lines = new FatLines();
  private drawn: unknown[] = [];

  constructor(private readonly viewer: Viewer) {
    viewer.body.add(this.lines.group);
    viewer.beforeFrame.add(() => this.lines.approach(viewer.depthUnits));
  }

  update({ step, scan, drawn, ink, inkPointed }: Shown): void {
    const { palette } = this.viewer;
    this.lines.paint(palette.ink, palette["ink-outline"]);
    const search = step === "body" || step === "plan" ? ink[scan?.info.id ?? ""] : undefined;
    const crops = cropsOf(scan);
    const now = [search, drawn.decided, crops, inkPointed];
    if (now.every((each, i) => each === this.drawn[i])) return;
    this.drawn = now;
    this.lines.set(openLines(search, drawn.decided, crops).map(({ name, points, closed, color, bridged }) => polyline({ points, closed, color, bridged: points.map((_, i) => name !== inkPointed || bridged[i]!) })));
    this.viewer.invalidate();
  }
}
