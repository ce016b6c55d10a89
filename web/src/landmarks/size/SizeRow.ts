// The scan's true size: both ends of a length on the scan, and what was measured on the patient.
import type { ScanSlice } from "../../scan/state";
import { isVolume } from "../../scan/state";
import type { PageSlice } from "../../store/page";
import { only } from "../../store/store";
import { button, type Option, problem, select } from "../../ui/controls";
import { el, setText, show } from "../../ui/dom";
import { numberField } from "../../ui/NumberField";
import type { Panel } from "../../ui/Panel";
import { isMark, markCalled } from "../picks";
import { sentenceOf } from "../questions/questions";
import type { LandmarksSlice } from "../state";
import type { SizeActions } from "./actions";
import { inScan, isRuler, rulerKey, type RulerSlice, type Side } from "./ruler";
import { size as text } from "./text";

type Shown = Pick<PageSlice & ScanSlice & LandmarksSlice & RulerSlice, "meta" | "problems" | "scan" | "picks" | "active" | "ruler">;

const CLICKED = "";
const SIDES: readonly Side[] = ["from", "to"];

export function createSizeRow(actions: SizeActions): Panel<Shown> {
  let mm: number | null = null; // on the patient
  let of = ""; // the scan, in the size for which it is written
  const said = el("p", { class: "muted small" });
  const measure = button(text.measure, () => actions.measure(), "quiet outlined", "points");
  measure.id = "measure-size";
  const ends = SIDES.map((side) => ({ side, list: select(text.ends[side], (value) => actions.choose(side, value === CLICKED ? null : value)) }));
  const field = numberField({ name: "measured", label: text.field, unit: "cm", min: 1, max: 300, hint: text.hint, mayBeEmpty: true, changed: (cm) => {
    mm = cm === null ? null : 10 * cm;
    field.set(cm);
  } });
  const apply = button(text.apply, () => (mm === null ? field.element.querySelector("input")!.focus() : void actions.apply(mm)), "outlined");
  apply.title = text.applyHint;
  const remove = button(text.remove, () => void actions.remove(), "quiet outlined");
  remove.title = text.removeHint;
  const protocol = el("a", { href: "/api/scan_protocol.pdf", target: "_blank" }, text.protocol);
  const wrong = problem(() => actions.dismiss());
  const element = el("section", { class: "panel", id: "true-size", "aria-label": text.label }, el("p", { class: "label" }, text.label), said, el("div", { class: "toolbar crop-row" }, measure, remove), ...ends.map(({ list }) => list.element), field.element, apply, wrong.element, protocol);
  return {
    element,
    select: only("meta", "problems", "scan", "picks", "active", "ruler"),
    update({ meta, problems, scan, picks, active, ruler }): void {
      show(element, scan !== null && !isVolume(scan.info));
      const called = (name: string): string => (isMark(name) ? markCalled(name) : (meta?.landmarks.find((entry) => entry.name === name)?.label ?? name));
      const names: Option<string>[] = Object.keys(picks.present).map((name) => ({ value: name, label: called(name) }));
      for (const { side, list } of ends) {
        const end = ruler[side];
        list.set([{ value: CLICKED, label: text.clicked }, ...names], typeof end === "string" ? end : CLICKED);
      }
      const isMeasuring = active !== null && isRuler(active);
      setText(measure.querySelector("span")!, isMeasuring ? text.stop : text.measure);
      measure.setAttribute("aria-pressed", String(isMeasuring));
      const found = inScan(ruler, picks.present);
      const scale = scan?.info.scale ?? null;
      show(remove, scale !== null);
      const [start, end] = scale?.between.map(called) ?? [];
      const known = scale ? text.scaled(scale.factor, start!, end!, scale.mm) : scan?.info.size_known === false ? text.askUnknown : text.ask;
      setText(said, active === rulerKey("from") ? text.clickFrom : active === rulerKey("to") ? text.clickTo : found !== null ? text.inScan(found) : known);
      if (of !== `${scan?.info.id} ${scale?.factor}`) mm = null;
      if (!of.startsWith(`${scan?.info.id} `)) field.drop();
      of = `${scan?.info.id} ${scale?.factor}`;
      field.set(mm === null ? null : mm / 10);
      apply.disabled = found === null;
      const isNew = problems.size !== undefined && wrong.element.hidden;
      wrong.set(problems.size && sentenceOf({ names: [], reason: problems.size }, meta?.landmarks ?? []));
      if (isNew) wrong.element.scrollIntoView({ block: "nearest" });
    },
  };
}
