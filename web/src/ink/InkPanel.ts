// The list of lines found on the skin: colour, kind and length of each, to be accepted, renamed, joined or dropped; and
// what is left to do until they lie on the other stance.
import type { DrawingSlice } from "../drawing/state";
import type { FitSlice } from "../fit/state";
import { cropsOf } from "../scan/crop";
import type { ScanSlice } from "../scan/state";
import type { StancesActions } from "../stances/actions";
import { scannedOther, type StancesSlice } from "../stances/state";
import { only } from "../store/store";
import { button, iconButton } from "../ui/controls";
import { el, fill, setText, show } from "../ui/dom";
import type { Panel } from "../ui/Panel";
import type { InkActions } from "./actions";
import { nearestJoint } from "./lines";
import { droppedIds, type FoundLine, type InkSlice, isMark, openLines } from "./state";
import * as text from "./text";

const words = text.ink;

type Shown = Pick<ScanSlice & DrawingSlice & FitSlice & StancesSlice & InkSlice, "scan" | "drawn" | "fit" | "isStarting" | "stances" | "ink">;

export function createInkPanel(ink: InkActions, stances: Pick<StancesActions, "dialog" | "fitBoth">): Panel<Shown> {
  const says = el("p", { class: "muted small" });
  const all = button("", () => ink.acceptAll(), "quiet outlined wide", "check");
  all.id = "accept-ink";
  const allWords = all.querySelector("span")!;
  const list = el("ul", { class: "layers ink-lines" });
  const marks = el("ul", { class: "layers ink-lines" });
  const marksWords = el("summary", {});
  const beside = el("details", { class: "why" }, marksWords, marks);
  const rest = button(words.dropAll, () => ink.dropAll(), "quiet outlined wide");
  const back = button("", () => ink.bringBack(), "quiet outlined wide", "undo");
  back.id = "bring-back-ink";
  const backWords = back.querySelector("span")!;
  const add = button(words.add, () => stances.dialog(true), "quiet outlined wide");
  add.id = "ink-other-stance";
  const both = button("", () => void stances.fitBoth(), "quiet outlined wide");
  both.id = "fit-both";
  const bothWords = both.querySelector("span")!;
  const note = el("p", { class: "muted small" });
  const element = el("section", { class: "panel ink-found", "aria-label": words.title, hidden: true }, el("p", { class: "label" }, words.title), says, all, list, beside, rest, back, add, both, note);

  function row(line: FoundLine, lines: readonly FoundLine[]): HTMLElement {
    const { name } = line;
    const chip = el("span", { class: "stroke", "aria-hidden": "true" });
    chip.style.background = line.color;
    const field = el("input", {
      type: "text",
      class: "line-name",
      value: name,
      title: name,
      maxlength: 100,
      "aria-label": words.name(name),
      onchange: () => {
        if (!ink.rename(name, field.value)) field.value = name;
      },
    });
    const joint = isMark(line) ? null : nearestJoint(line, lines);
    return el(
      "li",
      { "data-line": name, onpointerenter: () => ink.point(name), onpointerleave: () => ink.point(null), onfocusin: () => ink.point(name), onfocusout: () => ink.point(null) },
      chip,
      el("div", { class: "line-words" }, field, el("span", { class: "muted small length" }, words.length(line.lengthMm))),
      joint ? iconButton("link", words.join(name, joint.other.name), () => ink.join(name)) : null,
      iconButton("check", words.accept(name), () => ink.accept(name)),
      iconButton("close", words.drop(name), () => ink.drop(name)),
    );
  }

  return {
    element,
    select: only("scan", "drawn", "fit", "isStarting", "stances", "ink"),
    update(state: Shown): void {
      const search = state.scan ? state.ink[state.scan.info.id] : undefined;
      const other = scannedOther(state.stances);
      const hasLines = state.drawn.lines.present.length > 0 || (other?.drawn.lines.present.length ?? 0) > 0;
      const isFromInk = [search, other?.scan ? state.ink[other.scan.info.id] : undefined].some((each) => each?.state === "found" && each.lines.length > 0);
      const left = [state.fit, other?.fit].filter((fit) => fit?.state !== "done").length;
      const mayFit = other !== null && hasLines && isFromInk && left > 0 && !state.isStarting && state.fit?.state !== "running" && other.fit?.state !== "running";
      const mayAdd = other === null && hasLines && isFromInk;
      show(element, search !== undefined || mayFit || mayAdd);
      const lines = openLines(search, state.drawn.decided, cropsOf(state.scan));
      const dropped = search?.state === "found" ? droppedIds(state.drawn.decided).length : 0;
      const own = lines.filter((line) => !isMark(line));
      const others = lines.filter(isMark);
      const sentence = search?.state === "looking" ? words.looking : search?.state === "failed" ? search.reason : own.length > 0 ? words.what : others.length > 0 ? words.marksLeft : search?.state === "found" && search.lines.length > 0 ? words.decided : words.none;
      setText(says, search ? sentence : "");
      show(says, search !== undefined);
      show(all, own.length > 0);
      setText(allWords, words.acceptAll(own.length));
      show(rest, lines.length > 0);
      show(back, dropped > 0);
      setText(backWords, words.bringBack(dropped));
      show(beside, others.length > 0);
      setText(marksWords, words.marks(others.length));
      fill(list, own, () => own.map((line) => row(line, own)));
      fill(marks, others, () => others.map((line) => row(line, others)));
      show(add, mayAdd);
      show(both, mayFit);
      setText(bothWords, left === 2 ? words.fitBoth : words.fitOne);
      show(note, mayAdd || mayFit);
      setText(note, mayFit ? words.fitNote : words.addNote);
    },
  };
}
