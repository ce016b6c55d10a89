import { expect, test } from "vitest";
import type { Frame, LandmarkDefinition } from "../../src/api/types";
import { frameFromPicks, nextMissing, onWrongSide, type Picks, sideOf, withoutPick, withPick } from "../../src/landmarks/picks";
import { angleBetween, leftOf } from "../../src/viewer/frame";

const names = ["suprasternal_notch", "nipple_L", "nipple_R", "umbilicus"];
const list = names.map((name) => ({ name, label: name, latin: "", definition: "", easy: true, mirror: name })) as LandmarkDefinition[];
const upright: Frame = { up: [0, 1, 0], front: [0, 0, 1] };
const picks: Picks = { suprasternal_notch: [1, 300, 40], nipple_L: [95, 120.5, 130], nipple_R: [-98, 118, 128] };

test("the side of a landmark is in its name", () => {
  expect(["nipple_L", "nipple_R", "umbilicus"].map(sideOf)).toEqual(["left", "right", "middle"]);
});

test("picks are changed without touching the ones before", () => {
  const more = withPick(picks, "umbilicus", [0, -100, 90]);
  expect(Object.keys(more)).toEqual(names);
  expect(withoutPick(more, "umbilicus")).toEqual(picks);
  expect("umbilicus" in picks).toBe(false);
});

test("the next landmark is the first open one after the last, round the end of the list", () => {
  expect(nextMissing(list, {}, new Set())).toBe("suprasternal_notch");
  expect(nextMissing(list, picks, new Set())).toBe("umbilicus");
  expect(nextMissing(list, { umbilicus: [0, 0, 0] }, new Set(["suprasternal_notch"]), "umbilicus")).toBe("nipple_L");
  expect(nextMissing(list, picks, new Set(["umbilicus"]))).toBeNull();
});

test("swapped sides are noticed from each pair, also on a body that stands askew", () => {
  const swapped = { ...picks, nipple_L: picks.nipple_R!, nipple_R: picks.nipple_L! };
  const askew: Frame = { up: [0.6, 0.8, 0], front: [0, 0, 1] };
  expect([...onWrongSide(picks, upright)]).toEqual([]);
  expect([...onWrongSide(picks, askew)]).toEqual([]);
  expect([...onWrongSide(swapped, upright)].sort()).toEqual(["nipple_L", "nipple_R"]);
  expect([...onWrongSide({ nipple_L: [-50, 0, 0] }, upright)]).toEqual([]); // alone it says nothing
});

test("a pair and two points of the midline say how the body stands; fewer say nothing", () => {
  const askew: Picks = { nipple_L: [0, 100, 0], nipple_R: [0, -100, 0], umbilicus: [200, 5, -60], suprasternal_notch: [-150, 0, 0] };
  const frame = frameFromPicks(askew)!;
  expect(leftOf(frame)[1]).toBeCloseTo(1, 12);
  expect(frame.up[0]).toBeLessThan(-0.9);
  expect(frameFromPicks(withoutPick(askew, "nipple_L"))).toBeNull();
  expect(frameFromPicks(withoutPick(askew, "umbilicus"))).toBeNull();
  expect(frameFromPicks({})).toBeNull();
});

test("the skin of the midline leans back on an upright body, and is not taken for a plumb line", () => {
  const atRest: Picks = { umbilicus: [0, 158, 137.3], xiphoid: [0, 279.2, 143], suprasternal_notch: [0, 489.9, 72.1], nipple_L: [95, 300, 180], nipple_R: [-95, 300, 180] };
  for (const missing of [[], ["umbilicus"], ["suprasternal_notch"]]) {
    const picks = missing.reduce<Picks>((all, name) => withoutPick(all, name), atRest);
    const frame = frameFromPicks(picks)!;
    expect(angleBetween(frame, upright), `without ${missing.join()}`).toBeLessThan(0.01);
  }
});
