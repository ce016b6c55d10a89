// The first page: the patients of the week, each a link to the state of the work.
import type { Patient } from "../api/types";
import { only } from "../store/store";
import { button, iconButton, select } from "../ui/controls";
import { el, icon, setText, show } from "../ui/dom";
import type { Panel } from "../ui/Panel";
import type { PatientActions } from "./actions";
import { daysUntil, deletedAt, type Order, type PatientsSlice } from "./state";
import * as text from "./text";

const words = text.patients;
const moment = new Intl.DateTimeFormat(undefined, { dateStyle: "medium", timeStyle: "short" });

/** `addressOf`: the address that opens the patient's scans with their newest fits. */
export function createPatientList(patients: PatientActions, addressOf: (patient: Patient) => string): Panel<PatientsSlice> {
  const search = el("input", { type: "search", class: "search", placeholder: words.search, "aria-label": words.search, oninput: () => patients.search(search.value) });
  const orders = Object.entries(words.orders).map(([value, label]) => ({ value: value as Order, label }));
  const order = select<Order>(words.order, (by) => void patients.order(by), "field inline");
  const list = el("ul", { class: "patients" });
  const none = el("p", { class: "muted", hidden: true });
  const more = button(words.more, () => void patients.more(), "quiet outlined wide");
  const element = el("section", { class: "patient-list", "aria-label": words.title, hidden: true }, el("div", { class: "patients-head" }, el("h2", {}, words.title), search, order.element), list, none, more);

  let written: unknown[] = [];
  let made = new Map<string, HTMLElement>(); // rows by what they show
  const spoken = (patient: Patient): string => (patient.code === "" ? words.noCode : patient.code);

  function row(patient: Patient, isGoing: boolean): HTMLElement {
    if (isGoing) return el("li", { class: "is-going", "data-patient": patient.id }, el("span", {}, words.going(spoken(patient))), button(words.undo, () => patients.undo(patient.id), "outlined"));
    const code = el("input", {
      type: "text",
      class: "patient-code",
      value: patient.code,
      maxlength: 60,
      placeholder: words.code,
      "aria-label": words.code,
      title: words.code,
      autocomplete: "off",
      onchange: () => void patients.rename(patient.id, code.value),
    });
    const pictures = patient.scans.map(({ thumbnail }) => el("img", { src: thumbnail, alt: "", width: 48, height: 60, loading: "lazy", onerror: (event) => ((event.target as HTMLImageElement).style.visibility = "hidden") }));
    const states = patient.scans.map(({ stance, fit }) => `${stance}, ${words.fitted[fit?.state ?? "none"]}${words.verdicts[fit?.verdict ?? "good"]}`);
    const doubtful = patient.scans.map(({ fit }) => fit?.verdict).filter((verdict) => verdict === "check" || verdict === "unusable");
    const sign = doubtful.length === 0 ? [] : [icon("alert")];
    const until = deletedAt(patient);
    const facts = [moment.format(new Date(patient.created_at)), patient.plan_version > 0 ? words.plan : words.noPlan, until === null ? words.kept : words.left(daysUntil(until, new Date()))];
    const ask = el("div", { class: "sure", hidden: true }, el("p", {}, words.sure(spoken(patient), patient.scans.length)), button(words.no, () => show(ask, false), "quiet outlined"), button(words.yes, () => patients.remove(patient.id), "danger"));
    return el(
      "li",
      { "data-patient": patient.id },
      el("a", { class: "pictures", href: addressOf(patient), "aria-label": words.open(spoken(patient)), tabindex: -1 }, ...pictures),
      el("div", { class: "what" }, code, el("a", { href: addressOf(patient), class: doubtful.includes("unusable") ? "is-wrong" : "" }, ...sign, words.scans(states)), el("span", { class: "muted small" }, facts.join(" · "))),
      iconButton("close", words.remove(spoken(patient)), () => show(ask, Boolean(ask.hidden))),
      ask,
    );
  }

  return {
    element,
    select: only("patients"),
    update({ patients }: PatientsSlice): void {
      const { rows, next, search: sought, order: by, isKnown, isBusy, going } = patients;
      show(element, isKnown && (rows.length > 0 || sought !== ""));
      order.set(orders, by);
      const now = [rows, going];
      if (now.some((each, i) => each !== written[i])) {
        // A row that shows the same stays itself: what is being typed or asked in it is not lost to a list that comes again.
        const before = made;
        made = new Map(
          rows.map((each): [string, HTMLElement] => {
            const shown = JSON.stringify([each, going.includes(each.id)]);
            return [shown, before.get(shown) ?? row(each, going.includes(each.id))];
          }),
        );
        const wanted = [...made.values()];
        if (wanted.length !== list.children.length || wanted.some((each, i) => each !== list.children[i])) list.replaceChildren(...wanted);
      }
      written = now;
      setText(none, words.none(sought));
      show(none, rows.length === 0 && sought !== "" && !isBusy);
      show(more, next !== null);
      more.disabled = isBusy;
    },
  };
}
