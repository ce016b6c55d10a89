// Details of the scan: what the service read and why; what is cut away.  What is asked about it stands apart.
import { inSentence } from "../languages/words";
import type { PageSlice } from "../store/page";
import { problem, row } from "../ui/controls";
import { el, fill } from "../ui/dom";
import { later } from "../ui/later";
import type { Panel } from "../ui/Panel";
import { formatCm, formatCount } from "../ui/units";
import { sizeIn } from "../viewer/frame";
import type { ScanActions } from "./actions";
import { createCropRow } from "./cropping/CropRow";
import type { ScanSlice } from "./state";
import * as text from "./text";


type Shown = Pick<ScanSlice & PageSlice, "scan" | "lesionFiles" | "isCropping" | "problems"> & { readonly isUntouched: boolean };

/** `isUntouched`: nothing was made of the scan yet that reading its file again would lose. */
export function createScanPanel<More extends object>(actions: ScanActions, dismiss: () => void, isUntouched: (state: More) => boolean): Panel<Shown, PageSlice & ScanSlice & More> & { readonly asked: HTMLElement } {
  const facts = el("dl", { class: "facts" });
  const reasons = el("div", { class: "reasons" });
  const segments = later(
    ({ scan, lesionFiles, isUntouched }: Pick<Shown, "scan" | "lesionFiles" | "isUntouched">) => ({ scan, lesionFiles, isUntouched }),
    ({ scan, lesionFiles }) => scan !== null && ((scan.info.segments ?? []).length > 0 || scan.info.id in lesionFiles),
    async () => {
      const list = (await import("./volumes/SegmentList")).createSegmentList(actions);
      return { element: list.element, update: ({ scan, lesionFiles, isUntouched }) => scan && list.update(scan, lesionFiles[scan.info.id] ?? null, isUntouched) };
    },
  );
  const crop = createCropRow(actions);
  const wrong = problem(dismiss);
  const element = el("div", { class: "panel" }, facts, el("details", { class: "why" }, el("summary", {}, text.scan.why), reasons), crop.element);
  const asked = el("div", { class: "panel scan-asked" }, wrong.element, segments.element);
  return {
    element,
    asked,
    select: (state) => ({ scan: state.scan, lesionFiles: state.lesionFiles, isCropping: state.isCropping, problems: state.problems, isUntouched: isUntouched(state) }),
    update(state: Shown): void {
      wrong.set(state.problems.scan);
      if (!state.scan) return;
      const { info, frame, frameFrom } = state.scan;
      const size = info.size_m ? sizeIn(frame, info.frame, info.size_m) : null;
      fill(facts, [info.id, size], () => [
        row(text.scan.triangles, formatCount(info.triangles)),
        row(text.scan.unit, inSentence(text.units[info.unit])),
        size && row(text.scan.size, text.scan.sizeValue(size.map(formatCm))),
        info.reconstructed_from_points ? row(text.scan.surface, text.scan.fromPoints) : null,
        info.cut_away_cm2 ? row(text.scan.cutAway, formatCount(info.cut_away_cm2), "cm²", text.scan.cutAwayHint) : null,
        row(text.scan.stance, inSentence(text.scan.stances[info.stance.proposed]), "", info.stance.reason),
      ]);
      fill(reasons, [info.id, frameFrom], () => {
        const facing = frameFrom === "service" ? info.frame.reason : text.scan.facingFrom[frameFrom];
        const sentences = [info.unit_reason, info.size_doubt ?? "", info.stance.reason, facing, ...info.notes].filter((sentence) => sentence !== "");
        return sentences.map((sentence) => el("p", {}, sentence));
      });
      segments.update(state);
      crop.update(state);
    },
  };
}
