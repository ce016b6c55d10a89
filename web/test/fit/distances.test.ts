import { expect, test } from "vitest";
import shared from "./distance_colours.json" with { type: "json" };
import { colourOf, distanceWithin, readDistances, SCALE_MM, SCANNER_MM, screenColourOf, summarise } from "../../src/fit/distances/distances";

function bytesOf(values: number[]): ArrayBuffer {
  const view = new DataView(new ArrayBuffer(4 * values.length));
  values.forEach((value, i) => view.setFloat32(4 * i, value, true));
  return view.buffer;
}

test("the file is little-endian float32 on every machine, gaps are kept, and a torn file is refused", () => {
  expect([...readDistances(bytesOf([0.5, NaN, -3]))]).toEqual([0.5, NaN, -3]);
  expect(() => readDistances(new ArrayBuffer(6))).toThrow("whole");
});

test("the summary counts only what the scan shows", () => {
  const summary = summarise(new Float32Array([0, 1, -2, 6, NaN]))!;
  expect(summary).toEqual({ within: 0.75, beyond: 0.25, meanMm: 1.25 });
  expect(summarise(new Float32Array([NaN]))).toBeNull();
});

test("inside a triangle the value is that of the corners by weight, and unknown where one is unknown", () => {
  const distances = new Float32Array([1, 2, 4, NaN]);
  expect(distanceWithin(distances, [0, 1, 2], [0.25, 0.25, 0.5])).toBeCloseTo(2.75, 6);
  expect(distanceWithin(distances, [0, 1, 3], [0.5, 0.5, 0])).toBeNull();
});

test("the service's pictures and reports colour the same distances in the same way", () => {
  for (const [mm, rgb] of Object.entries(shared.srgb_by_mm)) expect(screenColourOf(Number(mm)), `${mm} mm`).toEqual(rgb);
});

const luminance = ([r, g, b]: [number, number, number]): number => 0.2126 * r + 0.7152 * g + 0.0722 * b;

test("within the scanner's error there is one colour, beyond it darker with each step, and beyond the scale no more", () => {
  expect(colourOf(SCANNER_MM)).toEqual(colourOf(0));
  expect(colourOf(-SCANNER_MM)).toEqual(colourOf(0));
  for (const sign of [-1, 1]) {
    const steps = [SCANNER_MM, 2.5, 3, 3.5, 4, 4.5, SCALE_MM].map((mm) => luminance(colourOf(sign * mm)));
    for (let i = 1; i < steps.length; i += 1) expect(steps[i]!).toBeLessThan(steps[i - 1]!);
    expect(colourOf(sign * 40)).toEqual(colourOf(sign * SCALE_MM));
  }
});

test("the two ends differ in the blue-yellow sense and in red-green, so that no colour blindness makes them one", () => {
  const [inside, outside] = [screenColourOf(-SCALE_MM), screenColourOf(SCALE_MM)];
  expect(inside[2] - inside[0]).toBeGreaterThan(80);
  expect(outside[0] - outside[2]).toBeGreaterThan(80);
});
