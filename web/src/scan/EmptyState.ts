// The first thing that anybody sees: where to drop a scan, the example one click away, and what this is.
import type { UnitChoice } from "../api/types";
import type { PageSlice } from "../store/page";
import { only } from "../store/store";
import { ANY_FILE, button, fileButton, problem, select } from "../ui/controls";
import { el, fill, icon, setText, show } from "../ui/dom";
import type { Panel } from "../ui/Panel";
import { formatMegabytes } from "../ui/units";
import type { ScanActions } from "./actions";
import { unitOptions } from "./ScanPanel";
import type { ScanSlice } from "./state";
import * as text from "./text";

type Shown = Pick<ScanSlice & PageSlice, "scan" | "loading" | "units" | "meta" | "examples" | "problems">;

export function createEmptyState(actions: ScanActions, dismiss: (place: "scan" | "service") => void): Panel<Shown> {
  const choose = fileButton(text.empty.choose, ANY_FILE, "primary", (file) => void actions.upload(file));
  choose.querySelector("input")!.id = "scan-file";
  const units = select<UnitChoice>(text.empty.units, actions.chooseUnits, "field inline");
  const models = select<string>(text.empty.model, (name) => void actions.chooseModel(name), "field inline");
  const limit = el("p", { class: "muted" });
  const examples = el("div", { class: "examples" });
  const wrong = problem(() => dismiss("scan"));
  const service = problem(() => dismiss("service"));
  const card = el(
    "div",
    { class: "empty-card" },
    el("div", { class: "drop-zone" }, icon("upload"), el("h2", {}, text.empty.title), limit, choose, units.element, models.element),
    wrong.element,
    service.element,
    el("p", { class: "or muted" }, text.empty.or),
    examples,
    el("div", { class: "lines muted" }, ...text.empty.lines.map((line) => el("p", {}, line))),
  );
  const bar = el("progress", { max: 1 });
  const phase = el("p", {});
  const busy = el("div", { class: "empty-card busy", hidden: true }, phase, bar);
  const element = el("div", { class: "empty" }, card, busy);
  return {
    element,
    select: only("scan", "loading", "units", "meta", "examples", "problems"),
    update(state: Shown): void {
      show(element, state.scan === null || state.loading !== null);
      show(card, state.loading === null);
      show(busy, state.loading !== null);
      const { loading } = state;
      if (loading) {
        setText(phase, text.loading[loading.phase](loading.title));
        if (loading.phase === "sending") bar.value = loading.share;
        else bar.removeAttribute("value"); // runs to and fro
      }
      units.set(unitOptions(), state.units);
      const names = state.meta?.models ?? [];
      models.set(names.map((value) => ({ value, label: text.models[value] ?? value })), state.meta?.model.name ?? "");
      show(models.element, names.length > 1);
      const megabytes = state.meta ? ` ${text.empty.limit(formatMegabytes(state.meta.limits.upload_bytes))}` : "";
      setText(limit, text.empty.formats + megabytes);
      fill(examples, state.examples, () =>
        state.examples.map((example) => button(example.label, () => void actions.takeExample(example.name), "quiet outlined")),
      );
      wrong.set(state.scan ? undefined : state.problems.scan);
      service.set(state.problems.service);
    },
  };
}
