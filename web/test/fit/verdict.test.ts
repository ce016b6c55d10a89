import { expect, test } from "vitest";
import { asksForLength, linesOn, otherReasons } from "../../src/fit/verdict";

const on = (shapes: { kind: string; line_error_mm: number | null }[]) => linesOn({ fit: { result: { line_error_mm: 20 }, drawing: null }, drawn: { onScan: { plan: { shapes } } } });

test("the number is that of the lines as soon as there are lines, and says so; a lesion inside the body is none", () => {
  expect(on([])).toEqual({ mm: 20, of: "lines on the breasts" });
  expect(on([{ kind: "lesion", line_error_mm: 7 }])).toEqual({ mm: 20, of: "lines on the breasts" });
  expect(on([{ kind: "lesion", line_error_mm: 30 }, { kind: "pattern", line_error_mm: 12 }, { kind: "line", line_error_mm: null }])).toEqual({ mm: 12, of: "drawn lines" });
});

test("a size that is not known, or unlikely, asks for a length", () => {
  const verdict = { level: "check" as const, reasons: ["Linien können weit daneben liegen.", "Der Rumpf ist 20 % größer."], about: ["lines", "size"] as ("lines" | "size")[] }; // in whatever language
  expect(asksForLength({ verdict })).toBe(true);
  expect(otherReasons({ verdict })).toEqual(["Der Rumpf ist 20 % größer."]);
  expect(asksForLength({ verdict: { ...verdict, about: ["lines", ""] } })).toBe(false);
  expect(otherReasons({ verdict: { level: "check", reasons: ["a"] } as never }), "of a version before").toEqual(["a"]);
});
