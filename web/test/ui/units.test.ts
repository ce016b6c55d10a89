import { expect, test } from "vitest";
import { inLanguage } from "../english";
import { formatCount, formatMm, formatPercent, formatSeconds, mmFrom, mmFromMetres, toUnit } from "../../src/ui/units";

test("every unit becomes millimetres and back", () => {
  expect(mmFrom(1, "m")).toBe(1000);
  expect(mmFrom(1, "dm")).toBeCloseTo(100, 12);
  expect(mmFrom(1, "cm")).toBeCloseTo(10, 12);
  expect(mmFrom(1, "in")).toBeCloseTo(25.4, 12);
  for (const unit of ["m", "dm", "cm", "mm", "in"] as const) expect(toUnit(mmFrom(3.7, unit), unit)).toBeCloseTo(3.7, 12);
  expect(mmFromMetres(0.25)).toBe(250);
});

test("numbers are written as people read them, and unknown ones as a dash", () => {
  expect(formatMm(1.234)).toBe("1.2");
  expect(formatMm(0.042)).toBe("0.04");
  expect(formatMm(null)).toBe("–");
  expect(formatSeconds(0.0712)).toBe("0.07");
  expect(formatSeconds(12.34)).toBe("12.3");
  expect(formatPercent(0.964)).toBe("96");
  expect(formatCount(61784)).toBe("61,784");
});

test("German writes decimals with a comma and thousands with a point", () =>
  inLanguage("de", () => {
    expect([formatMm(1.234), formatMm(0.042), formatMm(-0.001), formatSeconds(12.34), formatCount(61784), formatMm(1234.5)]).toEqual(["1,2", "0,04", "0,00", "12,3", "61.784", "1234,5"]);
  }));
