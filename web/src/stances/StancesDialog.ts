// Where another scan comes from: a file, a prediction, or those filed under a code that is typed.
import { locale } from "../languages/words";
import type { FitSlice } from "../fit/state";
import type { ScanSlice } from "../scan/state";
import type { PageSlice } from "../store/page";
import { only } from "../store/store";
import { ANY_FILE, button, fileButton, iconButton, problem } from "../ui/controls";
import { el, fill, setText, show } from "../ui/dom";
import type { Panel } from "../ui/Panel";
import { close as closeText } from "../ui/text";
import type { StancesActions } from "./actions";
import { type PatientScan, type StancesSlice, unscanned } from "./state";
import * as text from "./text";

const words = text.stances.dialog;
const made = text.stances.predicted;
const moment = new Intl.DateTimeFormat(locale(), { day: "numeric", month: "short", hour: "2-digit", minute: "2-digit" });

type Shown = Pick<PageSlice & ScanSlice & FitSlice & StancesSlice, "examples" | "problems" | "scan" | "stance" | "fit" | "stances">;

export function createStancesDialog(stances: StancesActions, dismiss: () => void): Panel<Shown> {
  const close = (): void => stances.dialog(false);
  const file = fileButton(words.upload, ANY_FILE, "outlined wide", (chosen) => void stances.upload(chosen));
  file.querySelector("input")!.id = "second-scan-file";
  const examples = el("div", { class: "choices" });
  const exampleLabel = el("p", { class: "label" }, words.examples);
  const code = el("input", { type: "text", id: "other-code", autocomplete: "off", placeholder: words.code, "aria-label": words.code });
  const find = el("form", { class: "inline-form", onsubmit: (event) => (event.preventDefault(), void stances.name(code.value)) }, code, el("button", { type: "submit", class: "button outlined" }, words.find));
  const moves = el("p", { class: "look-here small" });
  const theirs = el("ul", { class: "choices" });
  const busy = el("div", { class: "muted", role: "status" }, words.busy);
  const wrong = problem(dismiss);
  const elsewhere = el("details", {}, el("summary", {}, words.elsewhere), find, moves, theirs);
  const offerLabel = el("p", { class: "label" }, made.offer);
  const offer = el("div", { class: "choices in-row" });
  const offerWhat = el("p", { class: "muted small" });
  const choices = el("div", { class: "panel" }, file, exampleLabel, examples, offerLabel, offer, offerWhat, elsewhere);
  const offered = (scans: readonly PatientScan[]): HTMLElement[] =>
    scans.map(({ id, stance, created_at }) =>
      el("li", {}, el("button", { type: "button", class: "button outlined wide known", onclick: () => void stances.takeKnown(id) }, words.at(stance, moment.format(new Date(created_at))))),
    );
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
    select: only("examples", "problems", "scan", "stance", "fit", "stances"),
    update(state: Shown): void {
      const { isAdding, isBringing, predicting } = state.stances;
      if (isAdding && !element.open) element.showModal();
      if (!isAdding && element.open) element.close();
      if (!isAdding) return;
      show(busy, isBringing || predicting !== null);
      setText(busy, predicting ? made.busy(predicting) : words.busy);
      show(choices, !isBringing && predicting === null);
      wrong.set(state.problems.stances);
      const examplesShown = state.scan?.example ? state.examples : []; // they are all of one patient
      show(exampleLabel, examplesShown.length > 0);
      fill(examples, examplesShown, () => examplesShown.map(({ name, label }) => button(label, () => void stances.takeExample(name), "outlined")));
      const { named } = state.stances;
      const mine = state.scan?.info.patient_code ?? "";
      const unseen = unscanned(state);
      const mayPredict = state.fit?.state === "done";
      for (const each of [offerLabel, offer, offerWhat]) show(each, unseen.length > 0);
      fill(offer, [unseen.join(), mayPredict], () => unseen.map((stance) => el("button", { type: "button", class: "button outlined", disabled: !mayPredict, onclick: () => void stances.predict(stance) }, made.predict(stance))));
      setText(offerWhat, mayPredict ? made.offerWhat : made.needsFit);
      show(moves, named !== null);
      setText(moves, named ? words.moves(mine, named.code) : "");
      fill(theirs, named?.scans ?? [], () => offered(named?.scans ?? []));
    },
  };
}
