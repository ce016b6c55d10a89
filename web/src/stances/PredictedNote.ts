// On the pane of a predicted body: that nobody has scanned it, and how far off it may be.
import { wideOf } from "../fit/fingers";
import { linesOn } from "../fit/verdict";
import { el, setText, show } from "../ui/dom";
import { isPredicted, type StancesState } from "./state";
import * as text from "./text";

const words = text.stances.predicted;

export function createPredictedNote() {
  const badge = el("span", { class: "made-badge" }, words.badge);
  const busy = el("span", { class: "muted small", role: "status" });
  const note = el("p", { class: "made-note look-here small" });
  return {
    badge,
    busy,
    note,
    update({ other, predicting }: Pick<StancesState, "other" | "predicting">): void {
      const result = other && isPredicted(other) ? other.fit?.result : null;
      for (const each of [badge, busy, note]) show(each, result != null);
      if (!result) return;
      const lines = linesOn(other!);
      const margin = lines === null ? [] : [words.sure(lines.of, wideOf(lines.mm))];
      setText(note, [...(result.verdict?.reasons ?? []), ...margin].join(" "));
      setText(busy, predicting ? words.busy(predicting) : "");
    },
  };
}
