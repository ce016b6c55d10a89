// Details of the scan: what the service read, in which unit and why, and which way the body faces.
import type { UnitChoice } from "../api/types";
import type { PageSlice } from "../store/page";
import { button, type Option, problem, row, select } from "../ui/controls";
import { el, fill, setText, show } from "../ui/dom";
import { later } from "../ui/later";
import type { Panel } from "../ui/Panel";
import { formatCm, formatCount } from "../ui/units";
import { sizeIn, type Turn } from "../viewer/frame";
import type { ScanActions } from "./actions";
import { createCropRow } from "./cropping/CropRow";
import type { ScanSlice } from "./state";
import * as text from "./text";

const TURNS: Turn[] = ["around", "sideways", "forwards"];

export const unitOptions = (): Option<UnitChoice>[] =>
  (["auto", "mm", "cm", "dm", "m", "in", "ft"] as const).map((value) => ({ value, label: text.units[value] }));

const inSentence = (words: string): string => words.charAt(0).toLowerCase() + words.slice(1);

type Shown = Pick<ScanSlice & PageSlice, "scan" | "units" | "isCropping" | "problems"> & { readonly isUnconfirmed: boolean };

/** `isUnconfirmed`: nobody has said yet that size and direction are right. */
export function createScanPanel<More extends object>(actions: ScanActions, dismiss: () => void, isUnconfirmed: (state: More) => boolean): Panel<Shown, PageSlice & ScanSlice & More> & { readonly asked: HTMLElement } {
  const facts = el("dl", { class: "facts" });
  const reasons = el("div", { class: "reasons" });
  const again = select<UnitChoice>(text.scan.readAgain, (unit) => chosen && void actions.upload(chosen, unit));
  const turns = TURNS.map((turn) => {
    const made = button(text.scan.turns[turn], () => actions.turn(turn), "quiet outlined");
    made.title = text.scan.turnHints[turn];
    return made;
  });
  const segments = later(
    ({ scan, isUnconfirmed }: Pick<Shown, "scan" | "isUnconfirmed">) => ({ scan, isUnconfirmed }),
    ({ scan }) => (scan?.info.segments ?? []).length > 0,
    async () => {
      const list = (await import("./volumes/SegmentList")).createSegmentList(actions);
      return { element: list.element, update: ({ scan, isUnconfirmed }) => scan && list.update(scan, isUnconfirmed) };
    },
  );
  const crop = createCropRow(actions);
  const check = el("p", { class: "look-here", hidden: true }, text.scan.check);
  const doubt = el("p", { class: "look-here", role: "status", hidden: true });
  const unitNote = el("p", { class: "muted small", hidden: true }, text.scan.unitNote);
  const wrong = problem(dismiss);
  const element = el(
    "div",
    { class: "panel" },
    facts,
    el("details", { class: "why" }, el("summary", {}, text.scan.why), reasons),
    again.element,
    unitNote,
    el("p", { class: "label" }, text.scan.wrongWay),
    el("div", { class: "buttons" }, ...turns),
    el("p", { class: "muted small" }, text.scan.turnNote),
    crop.element,
  );
  const asked = el("div", { class: "panel scan-asked" }, wrong.element, check, doubt, segments.element);
  let chosen: File | null = null;
  return {
    element,
    asked,
    select: (state) => ({ scan: state.scan, units: state.units, isCropping: state.isCropping, problems: state.problems, isUnconfirmed: isUnconfirmed(state) }),
    update(state: Shown): void {
      wrong.set(state.problems.scan);
      if (!state.scan) return;
      const { info, file, frame, frameFrom } = state.scan;
      chosen = file;
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
        const sentences = [info.unit_reason, info.stance.reason, facing, ...info.notes].filter((sentence) => sentence !== "");
        return sentences.map((sentence) => el("p", {}, sentence));
      });
      segments.update(state);
      crop.update(state);
      show(check, state.isUnconfirmed);
      setText(doubt, info.size_doubt ?? "");
      show(doubt, (info.size_doubt ?? "") !== "");
      const hasOwnUnit = (info.segments ?? []).length > 0; // a label map
      show(again.element, file !== null && !hasOwnUnit);
      show(unitNote, file === null && state.scan.example === null && !hasOwnUnit);
      again.set(unitOptions(), state.units);
    },
  };
}
