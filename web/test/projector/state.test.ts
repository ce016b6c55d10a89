// The second screen as state: which place is asked for next, what a click does, what is remembered of a screen.
import { expect, test } from "vitest";
import type { Vector } from "../../src/api/types";
import { clicksKey, initialProjector, keptClicks, nextWanted, onBlack, projectionOf, type ProjectorState, screenKey, sightingsOf, withClick, withoutClick } from "../../src/projector/state";

const landmarks = ["a", "b", "c"].map((name, i) => ({ name, label: name, point: [i, 0, 0] as Vector }));
const start: ProjectorState = { ...initialProjector, landmarks, wanted: "a" };
const after = (state: ProjectorState, change: Partial<ProjectorState>): ProjectorState => ({ ...state, ...change });

test("one place after the other, in the stated order; the last one leaves nothing wanted", () => {
  let state = after(start, withClick(start, [10, 20]));
  expect(state).toMatchObject({ clicks: { a: [10, 20] }, wanted: "b" });
  state = after(state, withClick(state, [1, 1]));
  state = after(state, withClick(state, [2, 2]));
  expect(state.wanted).toBeNull();
  expect(withClick(state, [3, 3])).toEqual({});
});

test("a place that is passed over is asked for again at the end, and one that is taken away at once", () => {
  let state = after(start, { wanted: nextWanted(start, "a") });
  state = after(state, withClick(state, [1, 1]));
  state = after(state, withClick(state, [2, 2]));
  expect(state).toMatchObject({ clicks: { b: [1, 1], c: [2, 2] }, wanted: "a" });
  state = after(state, withoutClick(state, "c"));
  expect(state).toMatchObject({ clicks: { b: [1, 1] }, wanted: "c" });
  expect(sightingsOf(state).map(({ name }) => name)).toEqual(["b"]);
  expect(projectionOf(state)).toBe("tooFew");
});

test("a screen is known by its size and zoom", () => {
  expect(screenKey({ width: 1920, height: 1080 }, 1)).not.toBe(screenKey({ width: 1920, height: 1080 }, 1.25));
});

test("every colour can be seen on black, and keeps its hue", () => {
  const channels = (color: string): number[] => [1, 3, 5].map((at) => parseInt(color.slice(at, at + 2), 16));
  for (const color of ["#2b6cb0", "#2f855a", "#c53030", "#6b46c1", "#dd6b20", "#2c5282"]) {
    const [before, lifted] = [channels(color), channels(onBlack(color))];
    expect(Math.max(...lifted), color).toBe(255);
    expect(lifted.indexOf(Math.max(...lifted))).toBe(before.indexOf(Math.max(...before)));
    expect(lifted.indexOf(Math.min(...lifted))).toBe(before.indexOf(Math.min(...before)));
  }
  expect([onBlack("#101010"), onBlack("#f4f4f4")]).toEqual(["#ffffff", "#ffffff"]);
});

test("what was clicked comes back for the same fit on the same screen, and nothing else does", () => {
  expect(keptClicks('{"a":[10,20],"c":[1.5,2],"gone":[3,3]}', landmarks)).toEqual({ a: [10, 20], c: [1.5, 2] });
  for (const wrong of [null, "", "{", "null", "3", '{"a":[1]}', '{"a":["x",2]}', '{"a":[null,2]}']) expect(keptClicks(wrong, landmarks)).toEqual({});
  const screen = screenKey({ width: 1920, height: 1080 }, 1);
  expect(new Set([clicksKey("f1", screen), clicksKey("f2", screen), clicksKey("f1", screenKey({ width: 1920, height: 1080 }, 1.5)), screen]).size).toBe(4);
});
