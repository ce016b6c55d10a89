// What a fit is good for, in one of three verdicts: ready, points to check first, or of no use; with the reasons, and a way out.
import type { Result } from "../api/types";
import { ANY_FILE, button, fileButton } from "../ui/controls";
import { el, fill, icon, setText, show } from "../ui/dom";
import { fingersMark, fingersOf, wideOf } from "./fingers";
import type { Outdated } from "./outdated";
import { asksForLength, levelOf, marginOf, type linesOn, otherReasons } from "./verdict";
import * as text from "./text";

const words = text.verdict;

/** What a person is asked on this fit, and what checking brings. */
export interface Asks {
  readonly isKnown: boolean;
  readonly count: number;
  readonly points: number; // of those, that narrow the lines
  readonly expected: number | null; // mm, line error after all of them
  readonly outcome: string; // of the tour that led to this fit
}

export interface VerdictShown {
  readonly result: Pick<Result, "verdict"> | null;
  readonly failed: string | null; // why there is no result
  readonly lines: ReturnType<typeof linesOn>;
  readonly old: Outdated;
  readonly asks: Asks;
}

/** What a person can do from here; a visitor can do nothing. */
export interface WaysOut {
  again(): void;
  anotherFile(file: File): void;
  setPoints(): void;
  giveLength(): void;
}

export function createVerdictBox(ways: WaysOut | null) {
  const oldWords = el("p", {});
  const old = el("div", { class: "look-here outdated", role: "status", hidden: true }, oldWords, ways ? button(text.numbers.again, () => ways.again(), "outlined") : null);
  const verdict = el("div", { class: "verdict", role: "status", hidden: true });
  return {
    elements: [old, verdict],
    update({ result, failed, lines, old: why, asks }: VerdictShown): void {
      show(old, why !== null);
      setText(oldWords, why ? text.numbers.outdated[why] : "");
      show(verdict, (result !== null && asks.isKnown) || failed !== null); // what is asked comes a moment after the result: one verdict, not two
      const level = failed === null ? levelOf(result) : "unusable";
      const reasons = failed !== null ? [failed] : result === null ? [] : lines === null ? (result.verdict?.reasons ?? []) : otherReasons(result);
      const mm = lines?.mm ?? null;
      verdict.classList.toggle("is-wrong", level === "unusable");
      fill(verdict, [level, reasons, mm, lines?.of, asks], () => {
        if (level === "unusable") {
          const out = ways ? [fileButton(words.anotherFile, ANY_FILE, "outlined", (file) => ways.anotherFile(file)), button(words.setPoints, () => ways.setPoints(), "outlined")] : [];
          return [el("p", { class: "verdict-level" }, icon("alert"), words.cannot), ...reasons.map((reason) => el("p", {}, reason)), ...out];
        }
        const said = el("p", {}, words.lines(lines?.of ?? words.anyLines, wideOf(mm)), mm === null ? null : el("span", { class: "muted small" }, ` ${marginOf(mm)}`), `. ${asks.points > 0 && asks.expected !== null ? words.brings(asks.points, fingersOf(asks.expected) ?? 0) : mm === null ? words.unknown : words.band}`);
        return [
          el("p", { class: "verdict-level" }, fingersMark(fingersOf(mm)), asks.count > 0 ? words.check(asks.count) : level !== "check" ? words.ready : reasons.length === 0 ? words.draw(wideOf(mm)) : words.look),
          said,
          ...(asks.outcome === "" ? [] : [el("p", { class: "verdict-outcome" }, asks.outcome)]),
          ...reasons.map((reason) => el("p", { class: "muted" }, reason)),
          ...(ways && result !== null && asksForLength(result) ? [button(words.giveLength, () => ways.giveLength(), "outlined")] : []),
        ];
      });
    },
  };
}
