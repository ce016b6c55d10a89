// On the pane of a predicted body: that nobody has scanned it, how far off it may be, and its simulation.
import { marginOf } from "../fit/verdict";
import { button } from "../ui/controls";
import { el, setText, show } from "../ui/dom";
import { formatPercent } from "../ui/units";
import type { StancesActions } from "./actions";
import { isPredicted, stanceOf, type StancesState } from "./state";
import * as text from "./text";

const words = text.stances.predicted;

export function createPredictedNote(stances: Pick<StancesActions, "predict" | "cancelPrediction">) {
  let of: StancesState["other"] = null;
  const badge = el("span", { class: "made-badge" });
  const busy = el("span", { class: "muted small", role: "status" });
  const simulate = button(words.simulate, () => of && void stances.predict(stanceOf(of), true), "outlined");
  simulate.title = words.simulateHint;
  const cancel = button(words.cancel, stances.cancelPrediction, "outlined");
  const tools = el("span", { class: "made-tools" }, busy, simulate, cancel);
  const note = el("p", { class: "made-note look-here small" });
  return {
    badge,
    tools,
    note,
    update({ other, predicting }: Pick<StancesState, "other" | "predicting">): void {
      of = other;
      const result = other && isPredicted(other) ? other.fit?.result : null;
      for (const each of [badge, tools, note]) show(each, result != null);
      if (!result) return;
      setText(badge, words.badge(result.simulated ?? false));
      const margin = result.line_error_mm == null ? [] : [words.sure(marginOf(result.line_error_mm))];
      setText(note, [...(result.verdict?.reasons ?? []), ...margin].join(" "));
      setText(busy, predicting ? (predicting.simulate ? words.simulating(formatPercent(predicting.share), predicting.said) : words.busy(predicting.stance)) : "");
      show(simulate, predicting === null && !result.simulated);
      show(cancel, predicting?.simulate ?? false);
    },
  };
}
