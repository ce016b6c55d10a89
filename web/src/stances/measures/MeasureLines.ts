// On the body: where the measure runs that is pointed at in the table.  Along the skin a tape lies on it; callipers' lines lead
// through the body and are drawn over it.
import { polyline } from "../../drawing/lines/lines";
import { el } from "../../ui/dom";
import { FatLines } from "../../viewer/lines/FatLines";
import { Pins } from "../../viewer/Pins";
import type { Part, Viewer } from "../../viewer/Viewer";
import { measuredLines, type MeasuredLine } from "./measuredLines";
import type { StancesSlice } from "../state";

const COLOURS: Record<MeasuredLine["side"], string | undefined> = { left: "#1f5cb8", right: "#9a3477", value: undefined };

export class MeasureLines implements Part<StancesSlice> {
  private readonly onSkin = new FatLines();
  private readonly through = new FatLines(true);
  private readonly labels: Pins<MeasuredLine>;
  private shown: readonly unknown[] = [];

  /** `isOther`: of the stance that waits. */
  constructor(
    private readonly viewer: Viewer,
    private readonly isOther: boolean,
  ) {
    viewer.body.add(this.onSkin.group, this.through.group);
    viewer.beforeFrame.add(() => this.onSkin.approach(viewer.depthUnits));
    this.labels = new Pins(viewer, null);
  }

  update({ stances: { measures, isSecond } }: StancesSlice): void {
    const { palette } = this.viewer;
    for (const each of [this.onSkin, this.through]) each.paint(palette.ink, palette["ink-outline"]);
    const { file, isOpen, pointed } = measures;
    const stance = file?.stances[isSecond !== this.isOther ? 1 : 0]?.name ?? file?.stances[0]?.name ?? "";
    const isHere = file !== null && (!this.isOther || file.stances.length > 1);
    const now = [isOpen && isHere ? file : null, stance, pointed];
    if (now.every((each, i) => each === this.shown[i])) return;
    this.shown = now;
    this.write(isOpen && isHere ? measuredLines(file, stance, pointed) : []);
  }

  private write(lines: readonly MeasuredLine[]): void {
    const drawn = (isStraight: boolean) => lines.filter((line) => line.isStraight === isStraight).map(({ points, side }) => polyline({ points, closed: false, bridged: null, color: COLOURS[side] }));
    this.onSkin.set(drawn(false));
    this.through.set(drawn(true));
    this.labels.set(lines.filter(({ says }) => says !== "").map((line) => [line, line.label]), ({ says }) => el("div", { class: "tape-label" }, el("span", {}, says)));
  }
}
