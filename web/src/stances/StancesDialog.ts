// Where the second scan comes from: a file, the example patient, or a scan that was open in this tab.
import { SCAN_FILES } from "../scan/ScanPanel";
import type { ScanSlice } from "../scan/state";
import type { PageSlice } from "../store/page";
import { only } from "../store/store";
import { button, fileButton, iconButton, problem } from "../ui/controls";
import { el, fill, show } from "../ui/dom";
import type { Panel } from "../ui/Panel";
import { close as closeText } from "../ui/text";
import type { StancesActions } from "./actions";
import type { StancesSlice } from "./state";
import * as text from "./text";

const words = text.stances.dialog;
const moment = new Intl.DateTimeFormat("en-GB", { day: "numeric", month: "short", hour: "2-digit", minute: "2-digit" });

type Shown = Pick<PageSlice & ScanSlice & StancesSlice, "examples" | "problems" | "scan" | "stances">;

export function createStancesDialog(stances: StancesActions, dismiss: () => void): Panel<Shown> {
  const close = (): void => stances.dialog(false);
  const file = fileButton(words.upload, SCAN_FILES, "outlined wide", (chosen) => void stances.upload(chosen));
  file.querySelector("input")!.id = "second-scan-file";
  const examples = el("div", { class: "choices" });
  const known = el("ul", { class: "choices" });
  const none = el("p", { class: "muted small" }, words.knownNone);
  const busy = el("div", { class: "muted", role: "status" }, words.busy);
  const wrong = problem(dismiss);
  const choices = el("div", { class: "panel" }, file, el("p", { class: "label" }, words.examples), examples, el("p", { class: "label" }, words.known), known, none);
  const element = el(
    "dialog",
    { class: "help stances-dialog", "aria-labelledby": "stances-title", onclose: close },
    el("div", { class: "dialog-head" }, el("h2", { id: "stances-title" }, words.title), iconButton("close", closeText, close)),
    el("p", { class: "muted" }, words.what),
    wrong.element,
    busy,
    choices,
  );
  return {
    element,
    select: only("examples", "problems", "scan", "stances"),
    update(state: Shown): void {
      const { isAdding, isBringing } = state.stances;
      if (isAdding && !element.open) element.showModal();
      if (!isAdding && element.open) element.close();
      if (!isAdding) return;
      show(busy, isBringing);
      show(choices, !isBringing);
      wrong.set(state.problems.stances);
      fill(examples, state.examples, () => state.examples.map(({ name, label }) => button(label, () => void stances.takeExample(name), "outlined")));
      const list = state.stances.known.filter(({ id }) => id !== state.scan?.info.id);
      show(none, list.length === 0);
      fill(known, list, () =>
        list.map(({ id, title, stance, at }) =>
          el("li", {}, el("button", { type: "button", class: "button outlined wide known", onclick: () => void stances.takeKnown(id) }, el("span", {}, title), el("span", { class: "muted" }, words.at(stance, moment.format(new Date(at)))))),
        ),
      );
    },
  };
}
