// Step 3: the few choices before a fit, and what goes on during one.
import type { Actions } from "../app/actions";
import type { StanceChoice } from "../api/types";
import { wishLabel, wishLabels } from "./requestedDrawing";
import { el, setText, show } from "../ui/dom";
import { hasPattern } from "./modelLines";
import { doubtSentences, labelsOf } from "./landmarkWarnings";
import { ENOUGH } from "../landmarks/picks";
import { isFitting, pickCount, type Session, shownIteration } from "../app/session";
import { text } from "../ui/text";
import { button, problem, select } from "../ui/controls";
import type { Panel } from "../ui/Panel";

export function createFitPanel(actions: Actions, dismiss: () => void): Panel {
  const stance = select<StanceChoice>(text.fit.stance, actions.fit.chooseStance);
  const drawing = select<string>(text.fit.drawing, actions.fit.chooseDrawing);
  const preset = select<string>(text.fit.preset, actions.fit.choosePreset);
  const refine = el("input", { type: "checkbox", "aria-describedby": "refine-hint", onchange: () => actions.fit.chooseRefine(refine.checked) });
  const refining = el("div", { class: "toggle" }, el("label", { class: "check" }, refine, el("span", {}, text.fit.refine)), el("p", { id: "refine-hint" }, text.fit.refineHint));
  const hint = el("p", { class: "look-here", hidden: true });
  const progress = el("progress", { max: 1, "aria-label": text.fit.running });
  const phase = el("p", { class: "phase" });
  const retrying = el("p", { class: "look-here", hidden: true }, text.fit.retrying);
  const pattern = el("p", { class: "muted small", hidden: true }, text.fit.patternLater);
  const cancel = button(text.fit.cancel, () => void actions.fit.cancel(), "quiet outlined wide");
  const running = el("div", { class: "running", hidden: true }, phase, progress, pattern, retrying, cancel);
  const cancelled = el("p", { class: "muted", hidden: true }, text.fit.cancelled);
  const doubts = el("p", { class: "look-here", hidden: true });
  const notes = el("div", { class: "reasons" });
  const wrong = problem(dismiss);
  const element = el("div", { class: "panel" }, wrong.element, drawing.element, stance.element, preset.element, refining, hint, running, cancelled, doubts, notes);
  return {
    element,
    update(state: Session): void {
      const { fit, meta } = state;
      const busy = isFitting(state);
      const stances = (["auto", "standing", "supine"] as const).map((value) => ({ value, label: text.scan.stances[value] }));
      stance.set(stances, state.stance);
      const offered = (meta?.drawings ?? []).map(({ name, label }) => ({ value: name, label }));
      const isOffered = offered.some(({ value }) => value === state.drawing);
      drawing.set(isOffered ? offered : [...offered, { value: state.drawing, label: wishLabel(state.drawing, wishLabels(state)) || text.drawing.pattern.none }], state.drawing);
      preset.set((meta?.presets ?? []).map((name) => ({ value: name, label: text.fit.presets[name] ?? name })), state.preset);
      for (const each of [stance, drawing, preset]) each.enable(!busy);
      refine.checked = state.refine;
      refine.disabled = busy;
      const count = pickCount(state);
      show(hint, !busy && count < ENOUGH);
      setText(hint, count === 0 ? text.fit.noLandmarks : text.fit.fewLandmarks(count));
      show(running, busy);
      const shown = shownIteration(fit);
      setText(phase, shown ? `${text.fit.stage}: ${shown.stage}` : fit?.started || fit?.result ? text.fit.running : text.fit.waiting);
      const limit = fit?.started?.iterations_limit ?? 0;
      if (shown && limit > 0) progress.value = Math.min(1, shown.iteration / limit);
      else progress.removeAttribute("value");
      show(pattern, hasPattern(state.model?.side ?? null, fit?.drawingName ?? null));
      show(retrying, fit !== null && !fit.isConnected);
      show(cancelled, fit?.state === "cancelled");
      const doubted = fit ? doubtSentences(fit, labelsOf(meta?.landmarks)) : [];
      show(doubts, doubted.length > 0);
      setText(doubts, doubted.join(" "));
      const sentences = [...new Set([fit?.started?.stance_reason ?? "", ...(fit?.started?.notes ?? [])])].filter((each) => each !== "");
      setText(notes, sentences.join(" "));
      wrong.set(state.problems.fit);
    },
  };
}
