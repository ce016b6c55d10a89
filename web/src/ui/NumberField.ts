// A field for a number: decimal comma and point alike, the unit beside it, and a sentence below it for what it cannot take.
// Not type=number: an English browser drops a typed comma there, and 4,5 becomes 45.
import { el, setText, show } from "./dom";
import { numberField as words } from "./text";
import { formatUpTo } from "./units";

export interface Range {
  readonly label: string;
  readonly unit: string; // mm, cm, deg, h (an hour of the clock) or none
  readonly min: number | null;
  readonly max: number | null;
}

const THOUSANDS = /^[-+]?[1-9]\d{0,2}[.,]\d{3}$/; // 1.234 and 1,234: a thousand to one reader, decimals to another, whatever the page's language
const HOUR = /^(\d{1,2})[:.h]([0-5]\d)$/;

/** The number that is written; a sentence for what is none, may be read in two ways, or is out of range. */
export function readNumber(written: string, range: Range): number | string {
  const text = written.trim().replace("\u2212", "-").replace(range.unit === "cm" ? /\s*cm$/ : /\s*(mm|°|o'clock|Uhr)$/, "").replace(/\s*½$/, ".5");
  const time = range.unit === "h" && text.includes(":") ? HOUR.exec(text) : null;
  if (time) return within(Math.round((Number(time[1]) + Number(time[2]) / 60) * 100) / 100, range);
  if (/[.,].*[.,]/.test(text) || THOUSANDS.test(text)) return words.unclear(range.label, written.trim());
  if (!/^[-+]?(\d+([.,]\d*)?|[.,]\d+)$/.test(text)) return words.none(range.label, written.trim(), range.unit === "h");
  return within(Number(text.replace(",", ".")), range);
}

function within(value: number, { label, unit, min, max }: Range): number | string {
  return value < (min ?? -Infinity) || value > (max ?? Infinity) ? words.outside(label, min, max, unit) : value;
}

/** As people read it: an hour of the clock as a time, all else with as many decimals as it has, two at most. */
export function writtenNumber(value: number, unit: string): string {
  if (unit !== "h") return formatUpTo(Math.round(value * 100) / 100, 2);
  const minutes = Math.round(60 * value);
  return minutes % 60 === 0 ? String(minutes / 60) : `${Math.floor(minutes / 60)}:${String(minutes % 60).padStart(2, "0")}`;
}

interface Wishes extends Range {
  readonly name: string; // of the parameter
  readonly hint: string;
  /** Whether it may be left empty: then `changed` gets null. */
  readonly mayBeEmpty: boolean;
  /** Where its sentences stand; without it below the field. */
  readonly says?: HTMLElement;
  changed(value: number | null): void;
}

export interface NumberField {
  readonly element: HTMLElement;
  /** What is there now, unless somebody is writing, or has written what is refused; `placeholder` stands where it is empty, `note` below it. */
  set(value: number | null, placeholder?: string, note?: string): void;
  /** What is refused is of no interest any more. */
  drop(): void;
}

export function numberField(wishes: Wishes): NumberField {
  let now: number | null = null;
  let note = "";
  const below = wishes.says ?? el("span", { class: "field-note small", role: "status", hidden: true });
  const say = (sentence: string): void => {
    setText(below, sentence || note);
    show(below, (sentence || note) !== "");
    input.setCustomValidity(sentence);
    input.setAttribute("aria-invalid", String(sentence !== ""));
  };
  const input = el("input", {
    type: "text",
    inputmode: "decimal",
    autocomplete: "off",
    "data-parameter": wishes.name,
    oninput: () => say(""),
    onchange: () => {
      const isEmpty = input.value.trim() === "";
      const found = isEmpty ? (wishes.mayBeEmpty ? null : words.needed(wishes.label)) : readNumber(input.value, wishes);
      say(typeof found === "string" ? found : "");
      if (typeof found !== "string") wishes.changed(found);
    },
    onblur: () => input.validity.valid && write(),
  });
  const write = (): void => {
    const text = now === null ? "" : writtenNumber(now, wishes.unit);
    if (input.value !== text) input.value = text;
  };
  const unit = el("span", { class: "unit" }, wishes.unit === "" ? "" : ` ${words.units[wishes.unit] ?? wishes.unit}`);
  return {
    element: el("label", { class: "field", title: wishes.hint }, el("span", {}, wishes.label, unit), input, wishes.says ? null : below),
    set(value, placeholder = "", said = ""): void {
      now = value;
      if (input.placeholder !== placeholder) input.placeholder = placeholder;
      if (!input.validity.valid) return;
      if (document.activeElement !== input) write();
      if (note === said) return;
      note = said;
      say("");
    },
    drop(): void {
      if (input.validity.valid) return;
      write();
      say("");
    },
  };
}
