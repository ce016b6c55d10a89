// One patient: the scans by day, what is planned in a line, how sure it is, when it came and when it goes.
import { locale } from "../languages/words";
import type { Meta, Patient } from "../api/types";
import { fingersMark, fingersOf } from "../fit/fingers";
import { allGroups, mayPlan } from "../store/person";
import { button, select } from "../ui/controls";
import { el, show } from "../ui/dom";
import { createMenu, menuItem } from "../ui/menu";
import type { PatientActions } from "./actions";
import { daysUntil, deletedAt, latestScans, type PatientsState, plannedLine, sureness } from "./state";
import * as text from "./text";

const words = text.home;
const moment = new Intl.DateTimeFormat(locale(), { dateStyle: "medium", timeStyle: "short" });
const time = new Intl.DateTimeFormat(locale(), { hour: "2-digit", minute: "2-digit" });

let count = 0; // names of the menus

/** Today, yesterday, or the day, with the time. */
const when = (at: Date, now: Date): string => {
  const days = Math.round((new Date(now.toDateString()).getTime() - new Date(at.toDateString()).getTime()) / 86_400_000);
  return days === 0 || days === 1 ? words.near[days]!(time.format(at)) : moment.format(at);
};

export function patientCard(patient: Patient, isGoing: boolean, patients: PatientActions, points: PatientsState["points"], address: string, meta: Meta | null): HTMLElement {
  const spoken = patient.code === "" ? words.noCode : patient.code;
  if (isGoing) return el("li", { class: "is-going", "data-patient": patient.id }, el("span", {}, words.going(spoken)), button(words.undo, () => patients.undo(patient.id), "outlined"));
  const code = el("input", { type: "text", class: "patient-code", value: patient.code, maxlength: 60, placeholder: words.code, "aria-label": words.code, title: words.code, autocomplete: "off", hidden: true, onchange: () => void patients.rename(patient.id, code.value), onblur: () => named(false) });
  const name = el("a", { class: "patient-name", href: address }, spoken);
  const named = (isTyped: boolean): void => {
    show(code, isTyped);
    show(name, !isTyped);
    if (isTyped) code.select();
  };
  const ask = el("div", { class: "sure", hidden: true }, el("p", {}, words.sure(spoken, patient.scans.length)), button(words.no, () => show(ask, false), "outlined"), button(words.yes, () => patients.remove(patient.id), "danger"));
  count += 1;
  const menu = createMenu(`patient-menu-${count}`, "\u2022\u2022\u2022", words.more1(spoken), "icon-only", menuItem(words.rename, words.code, () => named(true)), menuItem(words.remove, "", () => show(ask, true)));
  menu.card.addEventListener("click", () => menu.close());
  const pictures = latestScans(patient).map(({ thumbnail, kind, stance }) =>
    el("span", { class: "picture-of" }, el("img", { src: thumbnail, alt: "", width: 62, height: 76, loading: "lazy", onerror: ({ target }) => ((target as HTMLElement).style.visibility = "hidden") }), el("span", {}, kind === "image" ? words.image : words.stances[stance])),
  );
  const { mm, says, isKnown } = sureness(patient, points);
  const until = deletedAt(patient);
  const groups = allGroups(meta);
  const group = select(words.group, (chosen) => void patients.give(patient.id, chosen), "field inline");
  group.set([{ value: "", label: words.groupNone }, ...[...new Set([...groups, ...(patient.group === null ? [] : [patient.group])])].map((each) => ({ value: each, label: each }))], patient.group ?? "");
  return el(
    "li",
    { "data-patient": patient.id },
    el("a", { class: "pictures", href: address, "aria-hidden": "true", tabindex: -1 }, ...pictures),
    el(
      "div",
      { class: "what" },
      el("div", { class: "named" }, name, code),
      el("p", {}, plannedLine(patient, meta?.patterns ?? [])),
      el("p", { class: "how-sure muted small" }, isKnown ? fingersMark(fingersOf(mm)) : null, says),
      el("p", { class: "muted small" }, [when(new Date(patient.created_at), new Date()), ...(until === null ? [] : [words.left(daysUntil(until, new Date()))])].join(" · ")),
    ),
    groups.length > 0 ? group.element : null,
    mayPlan({ meta }) ? menu.element : null,
    ask,
  );
}
