// The table of measures: left, right and difference, of one stance or of both and the change between them.
import type { Actions } from "../actions";
import { el, fill, icon, saveFile, setText, show } from "../dom";
import { formatCell, measuresCsv, type MeasureLine, measuresTable, type MeasuresTable } from "../stances/measuresTable";
import type { Session } from "../state/session";
import { measuredFits } from "../stances/state";
import { text } from "../text";
import { button, iconButton, problem } from "./controls";
import type { Panel } from "./Panel";

const words = text.stances.table;
const COLUMNS = ["left", "right", "difference", "whole"] as const;
const HEADS = { left: words.left, right: words.right, difference: words.difference, whole: words.both };
const UNITS = { mm: "mm", ml: "ml", "1": "" };

export function createMeasuresDialog({ stances }: Pick<Actions, "stances">, dismiss: () => void): Panel {
  const close = (): void => void stances.measures(false);
  let file: Session["stances"]["measures"]["file"] = null;
  const says = el("p", { class: "muted" });
  const holder = el("div", { class: "measures-scroll", tabindex: 0, role: "region", "aria-labelledby": "measures-title" });
  const busy = el("p", { class: "muted", role: "status" }, words.busy);
  const signs = el("p", { class: "muted small" });
  const copied = el("span", { class: "muted small", role: "status" });
  const copy = button(words.copy, () => void copyTable(), "outlined");
  const csv = button(words.csv, () => file && saveFile("measures.csv", measuresCsv(file.measures), "text/csv"), "outlined", "download");
  const report = el("a", { class: "button outlined", id: "report-both", download: "report.pdf" }, icon("download"), el("span", {}, words.report));
  const wrong = problem(dismiss);
  const element = el(
    "dialog",
    { class: "help measures", "aria-labelledby": "measures-title", onclose: close },
    el("div", { class: "dialog-head" }, el("h2", { id: "measures-title" }, words.title), iconButton("close", text.close, close)),
    says,
    wrong.element,
    busy,
    holder,
    signs,
    el("div", { class: "buttons-row" }, copy, copied, el("span", { class: "spring" }), csv, report),
  );

  async function copyTable(): Promise<void> {
    if (!file) return;
    try {
      await navigator.clipboard.writeText(measuresCsv(file.measures).replaceAll("\r\n", "\n"));
      setText(copied, words.copied);
    } catch {
      setText(copied, words.copyFailed);
    }
  }

  return {
    element,
    update(state: Session): void {
      const { measures } = state.stances;
      if (measures.isOpen && !element.open) {
        setText(copied, "");
        element.showModal();
      }
      if (!measures.isOpen && element.open) element.close();
      if (!measures.isOpen) return;
      file = measures.file;
      show(busy, measures.isBusy);
      wrong.set(state.problems.stances);
      const table = file && measuresTable(file);
      setText(says, table && table.groups.length > 1 ? words.two : words.one);
      show(holder, table !== null);
      fill(holder, [measures.of, table !== null], () => (table ? [tableOf(table)] : []));
      setText(signs, file ? `${file.signs} ${words.hint}` : "");
      for (const each of [copy, csv]) each.disabled = file === null;
      const fits = measuredFits(state);
      if (fits) report.href = fits[0].links.report + (fits[1] ? `?with=${encodeURIComponent(fits[1].id)}` : "");
    },
  };
}

function tableOf({ groups, lines }: MeasuresTable): HTMLElement {
  const used = groups.map((_, g) => COLUMNS.filter((column) => lines.some((line) => line.groups[g]![column].value !== null)));
  const top = el("tr", {}, el("th", { rowspan: 2, scope: "col" }, words.measure), ...groups.map((name, g) => el("th", { colspan: used[g]!.length, scope: "colgroup", class: "group" }, title(name))));
  const heads = el("tr", {}, ...groups.flatMap((_, g) => used[g]!.map((column, i) => el("th", { scope: "col", class: i === 0 ? "group" : "" }, HEADS[column]))));
  return el("table", {}, el("thead", {}, top, heads), el("tbody", {}, ...lines.map((line) => row(line, used, groups.length))));
}

const title = (name: string): string => {
  const [second, first] = name.split(" - ");
  return first ? words.change(second!, first) : name.charAt(0).toUpperCase() + name.slice(1);
};

function row(line: MeasureLine, used: readonly (readonly (typeof COLUMNS)[number][])[], groups: number): HTMLElement {
  const where = line.landmarks.map(({ stance, words: between }) => `${title(stance)}: ${between}`).join("\n");
  const tip = `${words.kind}: ${line.kind}\n${words.method}: ${line.method}\n${words.landmarks}: ${where}`;
  const unit = UNITS[line.unit];
  const name = el(
    "th",
    { scope: "row", title: tip },
    el("details", {}, el("summary", {}, words.names[line.measure] ?? line.measure, el("span", { class: "unit" }, ` ${line.kind}${unit === "" ? "" : `, ${unit}`}`)), el("p", { class: "muted small" }, tip)),
  );
  const cells = line.groups.flatMap((group, g) =>
    used[g]!.map((column, i) => {
      const cell = group[column];
      const isSigned = column === "difference" || (groups > 1 && g === groups - 1);
      const band = cell.low !== null && cell.high !== null ? words.band(formatCell({ ...cell, value: cell.low }, line.unit, isSigned), formatCell({ ...cell, value: cell.high }, line.unit, isSigned)) : "";
      return el("td", { class: i === 0 ? "group" : "", ...(band ? { title: band } : {}) }, formatCell(cell, line.unit, isSigned));
    }),
  );
  return el("tr", { "data-measure": line.measure, "data-kind": line.kind }, name, ...cells);
}
