// What became of each segment of a label map, and of files of lesions that were drawn on the scan's image.  While the page has
// the label map, and nothing was done with the scan, a person may say otherwise: the file is then read again.  A file's own words
// are shown only while the page has it, and kept nowhere.
import type { Segment, TakenAs, TakenLesions } from "../../api/types";
import { button, select } from "../../ui/controls";
import { el, fill, setText, show } from "../../ui/dom";
import { formatMmWhole } from "../../ui/units";
import type { ScanActions } from "../actions";
import type { ScanState } from "../state";
import * as text from "../text";

const words = text.segments;
const OPTIONS = (["lesion", "tissue", "unused"] as const).map((value) => ({ value, label: words.taken[value] }));

export function createSegmentList(actions: Pick<ScanActions, "takeSegments">) {
  let chosen: Record<number, TakenAs> = {};
  const none = el("p", { class: "look-here", role: "status", hidden: true }, words.none);
  const rows = el("ul", { class: "segments" });
  const again = button(words.again, () => void actions.takeSegments(chosen), "outlined wide");
  const fixed = el("p", { class: "muted small" }, words.fixed);
  const ownFile = el("div", {}, none, el("p", { class: "label", id: "segments-title" }, words.title), rows, again, fixed);
  const further = el("div", {}); // of files of lesions
  const element = el("section", { class: "segment-list", "aria-labelledby": "segments-title" }, ownFile, further);

  function row({ number, name, taken_as, why, radius_mm, label }: Segment, mayChoose: boolean, hasWords = mayChoose): HTMLElement {
    const own = hasWords && label ? el("span", {}, words.own(label)) : null;
    const size = radius_mm == null ? null : el("span", { class: "muted" }, words.across(formatMmWhole(2 * radius_mm)));
    const what = mayChoose
      ? select<TakenAs>(words.takeAs(name), (value) => {
          chosen = { ...chosen, [number]: value };
          show(again, true);
        })
      : null;
    what?.set(OPTIONS, taken_as);
    return el("li", { "data-segment": number }, el("p", {}, el("strong", {}, name), " ", own, " ", size), what ? what.element : el("p", {}, words.taken[taken_as]), el("p", { class: "muted small" }, why));
  }

  return {
    element,
    update({ info, file }: Pick<ScanState, "info" | "file">, lesionFiles: TakenLesions | null, isUnconfirmed: boolean): void {
      const segments = info.segments ?? [];
      const mayChoose = isUnconfirmed && file !== null;
      show(element, segments.length > 0 || lesionFiles !== null);
      show(ownFile, segments.length > 0);
      show(further, lesionFiles !== null);
      fill(further, lesionFiles, () => (lesionFiles ? [el("p", { class: "label" }, words.further), el("ul", { class: "segments" }, ...lesionFiles.segments.map((segment) => row(segment, false, true))), ...lesionFiles.notes.map((note) => el("p", { class: "muted small" }, note))] : []));
      if (segments.length === 0) return;
      show(none, segments.every(({ taken_as }) => taken_as !== "lesion"));
      setText(none, mayChoose ? words.none : words.noneAnyMore);
      fill(rows, [info.id, mayChoose], () => {
        chosen = {};
        show(again, false);
        return segments.map((segment) => row(segment, mayChoose));
      });
      show(fixed, !mayChoose);
    },
  };
}
