// A lesion made by three taps in the slices, resized by its handle and by keys.
import { expect, test } from "vitest";
import type { PlanLesion, Vector } from "../../src/api/types";
import { initialSlices } from "../../src/drawing/slices/state";
import { createLesionHand } from "../../src/stances/slices/lesionHand";
import type { SlicesShown } from "../../src/stances/slices/shown";

function hand(own: readonly PlanLesion[] = []) {
  let state = { scan: { info: { id: "mri", patient_code: "K", image: {} } }, slices: initialSlices, lesion: null, drawn: { lesions: own, onScan: null }, stances: { other: null } } as unknown as SlicesShown;
  const chosen: string[] = [];
  const actions = {
    slices: (change: object) => void (state = { ...state, slices: { ...state.slices, ...change } }),
    lesions: (lesions: readonly PlanLesion[]) => void (state = { ...state, drawn: { ...state.drawn, lesions } }),
    choose: (item: string) => void chosen.push(item),
  };
  return { made: createLesionHand(actions, () => state, () => undefined), now: () => state, take: (id: string) => (state = { ...state, lesion: id, slices: { ...state.slices, moves: true } }), chosen };
}
const key = (name: string) => ({ key: name }) as KeyboardEvent;

test("centre, then the edge twice: the radius is the mean of both distances, the cross goes to the centre, the name counts on", () => {
  const { made, now, chosen } = hand([{ kind: "lesion", id: "a", scan: "mri", name: "Lesion 1", center: [0, 0, 0], radius_mm: 5 }]);
  expect(made.isMarking()).toBe(false);
  made.begin();
  made.tap([10, 20, 30]);
  expect(now().slices.cross).toEqual({ scan: "mri", at: [10, 20, 30] });
  made.hover([10, 24, 30]);
  expect(made.sketch()).toMatchObject({ center: [10, 20, 30], radius: 4 });
  made.tap([16, 20, 30]);
  expect(now().slices.cross!.at, "an edge moves no cross").toEqual([10, 20, 30]);
  expect(made.key(key("Enter"), [10, 20, 41] as Vector)).toBe(true);
  const [, lesion] = now().drawn.lesions;
  expect(lesion).toMatchObject({ kind: "lesion", name: "Lesion 2", center: [10, 20, 30], radius_mm: 8.5 });
  expect(chosen).toEqual([`lesion ${lesion!.id}`]);
  expect([made.isMarking(), made.sketch()]).toEqual([false, null]);
});

test("Escape ends the marking, and nothing is planned", () => {
  const { made, now } = hand();
  made.begin();
  made.tap([1, 2, 3]);
  expect(made.key(key("Escape"), [0, 0, 0])).toBe(true);
  expect([made.isMarking(), now().drawn.lesions]).toEqual([false, []]);
  expect(made.key(key("Escape"), [0, 0, 0]), "the next one closes the slices").toBe(false);
});

test("in the hand: its handle and brackets change the radius within what the service takes, and nothing else of it", () => {
  const { made, now, take } = hand([{ kind: "lesion", id: "a", scan: "mri", name: "Index", center: [1, 2, 3], radius_mm: 5, radiology: "left" }]);
  take("a");
  made.resize(12.34, false);
  expect([made.held()!.radius, now().drawn.lesions[0]!.radius_mm], "not yet in the plan").toEqual([12.3, 5]);
  made.resize(12.34, true);
  made.key(key("]"), [0, 0, 0]);
  expect(now().drawn.lesions[0]).toEqual({ kind: "lesion", id: "a", scan: "mri", name: "Index", center: [1, 2, 3], radius_mm: 12.8, radiology: "left" });
  made.resize(500, true);
  expect(now().drawn.lesions[0]!.radius_mm).toBe(80);
});
