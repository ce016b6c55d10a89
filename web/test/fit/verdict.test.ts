import { expect, test } from "vitest";
import { linesOn } from "../../src/fit/verdict";

const on = (shapes: { kind: string; line_error_mm: number | null }[]) => linesOn({ fit: { result: { line_error_mm: 20 }, drawing: null }, drawn: { onScan: { plan: { shapes } } } });

test("the number is that of the lines as soon as there are lines, and says so; a lesion inside the body is none", () => {
  expect(on([])).toEqual({ mm: 20, of: "lines on the breasts" });
  expect(on([{ kind: "lesion", line_error_mm: 7 }])).toEqual({ mm: 20, of: "lines on the breasts" });
  expect(on([{ kind: "lesion", line_error_mm: 30 }, { kind: "pattern", line_error_mm: 12 }, { kind: "line", line_error_mm: null }])).toEqual({ mm: 12, of: "drawn lines" });
});
