import { expect, test } from "vitest";
import { asksForLength, linesOn } from "../../src/fit/verdict";

const on = (shapes: { kind: string; line_error_mm: number | null }[]) => linesOn({ fit: { result: { line_error_mm: 20 }, drawing: null }, drawn: { onScan: { plan: { shapes } } } });

test("the number is that of the lines as soon as there are lines, and says so; a lesion inside the body is none", () => {
  expect(on([])).toEqual({ mm: 20, of: "lines on the breasts" });
  expect(on([{ kind: "lesion", line_error_mm: 7 }])).toEqual({ mm: 20, of: "lines on the breasts" });
  expect(on([{ kind: "lesion", line_error_mm: 30 }, { kind: "pattern", line_error_mm: 12 }, { kind: "line", line_error_mm: null }])).toEqual({ mm: 12, of: "drawn lines" });
});

test("a size that is not known, or unlikely, asks for a length", () => {
  const reasons = ["The trunk is 20 % larger than most women's.", "The size of this scan is not known, and all errors allow for 4 % of it.", "Lines may be far off."];
  expect(reasons.map(asksForLength)).toEqual([true, true, false]);
});
