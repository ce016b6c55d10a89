// What goes on during a fit; and its few settings, for the details.
import { ENOUGH } from "../landmarks/picks";
import { type Asked, openQuestions, sentenceOf } from "../landmarks/questions/questions";
import { type LandmarksSlice, pickCount } from "../landmarks/state";
import type { PageSlice } from "../store/page";
import { only } from "../store/store";
import { button, problem, select } from "../ui/controls";
import { el, setText, show } from "../ui/dom";
import type { Panel } from "../ui/Panel";
import type { FitActions } from "./actions";
import { type FitSlice, isFitting, shownIteration } from "./state";
import * as text from "./text";

type Shown = Pick<PageSlice & LandmarksSlice & FitSlice, "meta" | "problems" | "picks" | "certain" | "preset" | "refine" | "fit" | "isStarting"> & Pick<Asked, "scan">;

export function createFitPanel(actions: FitActions, dismiss: () => void): Panel<Shown> & { readonly settings: HTMLElement } {
  const preset = select<string>(text.fit.preset, actions.choosePreset);
  const refine = el("input", { type: "checkbox", "aria-describedby": "refine-hint", onchange: () => actions.chooseRefine(refine.checked) });
  const refining = el("div", { class: "toggle" }, el("label", { class: "check" }, refine, el("span", {}, text.fit.refine)), el("p", { id: "refine-hint" }, text.fit.refineHint));
  const hint = el("p", { class: "look-here", hidden: true });
  const progress = el("progress", { max: 1, "aria-label": text.fit.running });
  const phase = el("p", { class: "phase" });
  const retrying = el("p", { class: "look-here", hidden: true }, text.fit.retrying);
  const cancel = button(text.fit.cancel, () => void actions.cancel(), "quiet outlined wide");
  const running = el("div", { class: "running", hidden: true }, phase, progress, retrying, cancel);
  const cancelled = el("p", { class: "muted", hidden: true }, text.fit.cancelled);
  const warnings = el("p", { class: "look-here", hidden: true });
  const notes = el("div", { class: "reasons" });
  const wrong = problem(dismiss);
  const element = el("div", { class: "panel fit-state" }, wrong.element, running, cancelled, warnings);
  const settings = el("div", { class: "panel" }, preset.element, refining, hint, notes);
  return {
    element,
    settings,
    select: only("meta", "problems", "scan", "picks", "certain", "preset", "refine", "fit", "isStarting"),
    update(state: Shown): void {
      const { fit, meta } = state;
      const busy = isFitting(state);
      preset.set((meta?.presets ?? []).map((name) => ({ value: name, label: text.fit.presets[name] ?? name })), state.preset);
      preset.enable(!busy);
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
      show(retrying, fit !== null && !fit.isConnected);
      show(cancelled, fit?.state === "cancelled");
      const unfollowed = fit ? openQuestions(state).map((question) => sentenceOf(question, meta?.landmarks ?? [])) : [];
      const toSay = [...unfollowed, ...(fit?.result?.drawing_missing ?? [])];
      show(warnings, toSay.length > 0);
      setText(warnings, toSay.join(" "));
      const sentences = [...new Set([fit?.started?.stance_reason ?? "", ...(fit?.started?.notes ?? [])])].filter((each) => each !== "");
      setText(notes, sentences.join(" "));
      wrong.set(fit?.state === "failed" ? undefined : state.problems.fit); // why a fit failed is its verdict
    },
  };
}
