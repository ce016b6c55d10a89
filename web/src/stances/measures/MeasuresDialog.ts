// The table of measures: left, right and difference, of one stance or of both and the change between them.
import "./measures.css";
import { ask } from "../../api/client";
import type { FitSlice } from "../../fit/state";
import { capital, inSentence } from "../../languages/words";
import type { ScanSlice } from "../../scan/state";
import type { PageSlice } from "../../store/page";
import { only } from "../../store/store";
import { button, iconButton, problem } from "../../ui/controls";
import { withMargins } from "../../ui/margins";
import { el, fill, icon, setText, show } from "../../ui/dom";
import type { Panel } from "../../ui/Panel";
import { close as closeText } from "../../ui/text";
import type { StancesActions } from "../actions";
import { isNamed, measuredDoubts, type MeasureLine, type MeasuresTable, measuresTable, saidOf, stanceTitle } from "./measuresTable";
import { measuredFits, type StancesSlice } from "../state";
import * as text from "./text";

const words = text.table;
const COLUMNS = ["left", "right", "difference"] as const;
const HEADS = { left: words.left, right: words.right, difference: words.difference };
const UNITS = { mm: "mm", ml: "ml", "1": "", grade: "" };

type Shown = Pick<PageSlice & ScanSlice & FitSlice & StancesSlice, "meta" | "problems" | "scan" | "fit" | "stances">;

export function createMeasuresDialog(stances: StancesActions, dismiss: () => void): Panel<Shown> {
  const close = (): void => void stances.measures(false);
  const says = el("p", { class: "muted" }, words.one);
  const doubts = el("div", { role: "status" });
  const holder = el("div", { class: "measures-scroll", tabindex: 0, role: "region", "aria-labelledby": "measures-title" });
  const busy = el("div", { class: "muted", role: "status" }, words.busy);
  const signs = el("p", { class: "muted small" });
  const copied = el("span", { class: "muted small", role: "status" });
  const copy = button(words.copy, () => void copyTable(), "outlined");
  const csv = el("a", { class: "button outlined", download: "measures.csv" }, icon("download"), el("span", {}, words.csv));
  const report = el("a", { class: "button outlined", id: "report-both", download: "report.pdf" }, icon("download"), el("span", {}, words.report));
  const wrong = problem(dismiss);
  const element = el(
    "dialog",
    { class: "help measures", "aria-labelledby": "measures-title", onclose: close },
    el("div", { class: "dialog-head" }, el("h2", { id: "measures-title" }, words.title), iconButton("close", closeText, close)),
    says,
    doubts,
    wrong.element,
    busy,
    holder,
    signs,
    el("div", { class: "buttons-row" }, copy, copied, el("span", { class: "spring" }), csv, report),
  );

  async function copyTable(): Promise<void> {
    try {
      await navigator.clipboard.writeText(await (await ask(csv.href)).text());
      setText(copied, words.copied);
    } catch {
      setText(copied, words.copyFailed);
    }
  }

  return {
    element,
    select: only("meta", "problems", "scan", "fit", "stances"),
    update(state: Shown): void {
      const { measures } = state.stances;
      if (measures.isOpen && !element.open) {
        setText(copied, "");
        element.showModal();
      }
      if (!measures.isOpen && element.open) element.close();
      if (!measures.isOpen) return;
      const { file } = measures;
      show(busy, measures.isBusy);
      wrong.set(state.problems.stances);
      const table = file && measuresTable(file);
      const isOfTwo = table !== null && table.groups.length > 1;
      const doubted = file ? measuredDoubts(file) : [];
      fill(doubts, doubted, () => (doubted.length > 0 ? [el("p", { class: "look-here" }, doubted.join(" "))] : [])); // one box: the table needs the room
      show(says, table !== null && !isOfTwo); // of two, the signs below the table say what a change is
      element.classList.toggle("of-two", isOfTwo);
      show(holder, table !== null);
      fill(holder, [measures.of, table !== null], () => (table ? [tableOf(table, new Map(state.meta?.landmarks.map(({ name, label }) => [name, label])), (key) => stances.pointAt(key))] : []));
      setText(signs, file ? `${capital(file.signs)}. ${words.hint}` : "");
      copy.disabled = file === null;
      const fits = measuredFits(state);
      if (!fits) return;
      const [{ links }, other] = fits;
      const both = other ? `?with=${encodeURIComponent(other.id)}` : "";
      report.href = links.report + both;
      csv.href = links.measures.replace(/json$/, "csv") + both;
    },
  };
}

function tableOf({ groups, lines }: MeasuresTable, labels: ReadonlyMap<string, string>, pointAt: (key: string | null) => void): HTMLElement {
  const top = el("tr", {}, el("th", { rowspan: 2, scope: "col" }, words.measure), ...groups.map((name) => el("th", { colspan: COLUMNS.length, scope: "colgroup", class: "group" }, title(name))));
  const heads = el("tr", {}, ...groups.flatMap(() => COLUMNS.map((column, i) => el("th", { scope: "col", class: i === 0 ? "group" : "" }, HEADS[column]))));
  return el("table", {}, el("thead", {}, top, heads), el("tbody", {}, ...lines.flatMap((line) => row(line, groups.length, labels, pointAt))));
}

const title = (name: string): string => {
  const [second, first] = name.split(" - ");
  return first ? words.change(inSentence(stanceTitle(second!)), inSentence(stanceTitle(first))) : stanceTitle(name);
};

function row(line: MeasureLine, groups: number, labels: ReadonlyMap<string, string>, pointAt: (key: string | null) => void): HTMLElement[] {
  const readable = (names: string): string => names.replace(/[a-z]+(_[a-zA-Z]+)*/g, (name) => labels.get(name) ?? name);
  const where = line.landmarks.map(({ stance, words: between }) => `${title(stance)}: ${readable(between)}`);
  const facts = [[words.kind, words.kindSaid(line.kind)], [words.method, line.method], [words.landmarks, where.join("\n")]] as const;
  const unit = UNITS[line.unit];
  const list = el("dl", {}, ...facts.flatMap(([fact, value]) => [el("dt", {}, fact), el("dd", {}, value)]));
  const more = el("tr", { class: "facts", hidden: true }, el("td", { colspan: 1 + groups * COLUMNS.length }, list));
  const label = el("span", {}, line.label, el("span", { class: "unit" }, ` ${words.kindSaid(line.kind)}${unit === "" ? "" : `, ${unit}`}`));
  const open = el(
    "button",
    {
      type: "button",
      class: "measure-name",
      "aria-expanded": "false",
      title: facts.map(([fact, value]) => `${fact}: ${value}`).join("\n"),
      onclick: () => {
        more.hidden = !more.hidden;
        open.setAttribute("aria-expanded", String(!more.hidden));
      },
    },
    icon("on"),
    label,
  );
  const cells = line.cells.flatMap((group) => {
    const write = (column: (typeof COLUMNS)[number] | "value", attributes: { class: string; colspan?: number }): HTMLElement => {
      if (isNamed(group?.not_seen, column)) return el("td", { ...attributes, title: words.notSeenHint }, words.notSeen);
      if (isNamed(group?.not_known, column)) return el("td", { ...attributes, title: words.notKnownHint }, words.notKnown);
      const said = saidOf(group, column);
      if (isNamed(group?.vague, column)) return el("td", { ...attributes, class: `${attributes.class} vague`, title: words.vagueHint(said) }, words.vague, el("span", { class: "visually-hidden" }, `: ${said}`));
      return el("td", attributes, ...withMargins(said));
    };
    const isWhole = group !== null && (group.value !== null || isNamed(group.not_seen, "value") || isNamed(group.not_known, "value"));
    if (isWhole) return [write("value", { class: "group whole", colspan: COLUMNS.length })]; // one value for both sides
    return COLUMNS.map((column, i) => write(column, { class: i === 0 ? "group" : "" }));
  });
  const [at, away] = [(): void => pointAt(line.key), (): void => pointAt(null)];
  return [el("tr", { "data-measure": line.measure, "data-kind": line.kind, onpointerenter: at, onpointerleave: away, onfocusin: at, onfocusout: away }, el("th", { scope: "row" }, open), ...cells), more];
}
