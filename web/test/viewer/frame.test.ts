import { expect, test } from "vitest";
import type { Frame } from "../../src/api/types";
import { cross, dot, leftOf, sizeIn, tidyFrame, turned } from "../../src/viewer/frame";

const upright: Frame = { up: [0, 1, 0], front: [0, 0, 1] };

test("facing us upright, the patient's left is on +X", () => {
  expect(leftOf(upright)).toEqual([1, 0, 0]);
});

test("four turns about any axis lead back to the start", () => {
  for (const turn of ["around", "sideways", "forwards"] as const) {
    let frame = upright;
    for (let i = 0; i < 4; i += 1) frame = turned(frame, turn);
    expect([...frame.up, ...frame.front].map((x) => x + 0)).toEqual([...upright.up, ...upright.front]); // -0 + 0 is 0
    expect(turned(upright, turn)).not.toEqual(upright);
  }
});

test("a slanted or useless proposal becomes a right-angled frame", () => {
  const slanted = tidyFrame({ up: [0, 2, 0], front: [0, 1, 1] });
  expect(slanted.up).toEqual([0, 1, 0]);
  expect(dot(slanted.up, slanted.front)).toBeCloseTo(0, 12);
  for (const front of [[0, 0, 0], [0, 1, 0]] as const) {
    const frame = tidyFrame({ up: [0, 1, 0], front: [...front] });
    expect(Math.hypot(...frame.front)).toBeCloseTo(1, 12);
    expect(Math.hypot(...cross(frame.up, frame.front))).toBeCloseTo(1, 12);
  }
});

test("a size goes along when the body is turned", () => {
  const size = [0.45, 0.64, 0.23] as const; // wide, high, deep
  expect(sizeIn(upright, upright, size)).toEqual([0.45, 0.64, 0.23]);
  expect(sizeIn(turned(upright, "around"), upright, size)).toEqual([0.23, 0.64, 0.45]);
  expect(sizeIn(turned(upright, "sideways"), upright, size)).toEqual([0.64, 0.45, 0.23]);
  const slanted = tidyFrame({ up: [0.1, 1, 0.1], front: [0.2, 0, 1] }); // as landmarks or a fit say it
  expect(sizeIn(slanted, upright, size)).toEqual([0.45, 0.64, 0.23]);
});
