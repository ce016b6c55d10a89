// Numbers of the table of measures: as finely as their bands allow, and each with its band.
import { expect, test } from "vitest";
import { formatCell, formatMargin } from "../../../src/stances/measures/measuresTable";

test("a number is written as finely as its band allows, with the band behind it", () => {
  const written = (value: number, margin: number | null, unit: "mm" | "ml" | "1", isSigned = false): string => {
    const cell = margin === null ? { value, low: null, high: null } : { value, low: value - margin, high: value + margin };
    return formatCell(cell, unit, isSigned) + formatMargin(cell, unit);
  };
  expect(written(201.34, null, "mm")).toBe("201.3");
  expect(written(201.34, 0.6, "mm")).toBe("201.3\u00a0±0.6");
  expect(written(201.34, 5.2, "mm")).toBe("201\u00a0±5");
  expect(written(268.7, 28.6, "ml")).toBe("270\u00a0±30");
  expect(written(-9.6, 5, "mm", true)).toBe("\u221210\u00a0±5");
});
