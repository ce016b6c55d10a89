import { expect, test } from "vitest";
import type { Vector } from "../../src/api/types";
import { certainAt, certainNames } from "../../src/landmarks/certain";
import { exchanged, type Picks } from "../../src/landmarks/picks";
import { type Asked, type Judgement, openQuestions, sentenceOf } from "../../src/landmarks/questions/questions";

const picks: Picks = { notch: [0, 200, 10], nipple_L: [90, 0, 60], nipple_R: [-90, 0, 60], umbilicus: [0, -200.123, 40] };
const exchangedSides = { names: ["nipple_L", "nipple_R"], reason: "nipple_L and nipple_R look exchanged; they were not followed." };
const off = { names: ["umbilicus"], reason: "umbilicus is 62 mm from where the model puts it; it was not followed." };
const unusual = { names: ["notch"], reason: "notch is unusual." };
const upright = { up: [0, 1, 0] as Vector, front: [0, 0, 1] as Vector };

const inMetres = (places: Picks) => ({ landmarks_picked: Object.fromEntries(Object.entries(places).map(([name, at]) => [name, at.map((mm) => Number((mm / 1000).toFixed(6))) as Vector])), scan: { unit: "m" } });
const ended = (part: object, given: Picks = picks): Judgement => ({ started: null, picks: given, result: { ...inMetres(given), ...part } });
const asked = (fit: Judgement | null, more: Partial<Asked> = {}): Asked => ({ fit, scan: { frame: upright }, picks: { present: picks }, certain: {}, ...more });
const names = (state: Asked): (readonly string[])[] => openQuestions(state).map((question) => question.names);

test("a fit asks about what it did not follow and about what is unusual", () => {
  const state = asked(ended({ landmarks_not_followed: [exchangedSides, off], landmarks_unusual: [unusual] }));
  expect(openQuestions(state)).toEqual([
    { ...exchangedSides, exchange: "sides" },
    { ...off, exchange: null },
    { ...unusual, exchange: null },
  ]);
  expect(names(asked(ended({})))).toEqual([]);
  expect(names(asked(null))).toEqual([]);
});

test("two that are no partners are exchanged with each other, more than two each with its partner", () => {
  const two = { names: ["notch", "umbilicus"], reason: "" };
  const all = { names: Object.keys(picks), reason: "" };
  expect(openQuestions(asked(ended({ landmarks_not_followed: [two, all] }))).map(({ exchange }) => exchange)).toEqual(["two", "all"]);
  expect(exchanged(picks, two.names)).toEqual({ ...picks, notch: picks.umbilicus, umbilicus: picks.notch });
  expect(exchanged(picks, exchangedSides.names)).toEqual({ ...picks, nipple_L: picks.nipple_R, nipple_R: picks.nipple_L });
  expect(exchanged(picks, all.names)).toEqual(exchanged(picks, exchangedSides.names));
  expect(exchanged({ nipple_L: [1, 2, 3], notch: [4, 5, 6] }, ["a", "b", "nipple_L", "notch"])).toEqual({ nipple_R: [1, 2, 3], notch: [4, 5, 6] });
  expect(exchanged(exchanged(picks, all.names), all.names)).toEqual(picks);
});

test("each answer closes the question: kept, taken out, exchanged, placed elsewhere", () => {
  const fit = ended({ landmarks_not_followed: [exchangedSides, off] });
  const { umbilicus: _gone, ...rest } = picks;
  expect(names(asked(fit, { certain: certainAt(picks, ["umbilicus"]) }))).toEqual([exchangedSides.names]);
  expect(names(asked(fit, { picks: { present: rest } }))).toEqual([exchangedSides.names]);
  expect(names(asked(fit, { picks: { present: { ...picks, umbilicus: [0, -200.3, 40] } } }))).toEqual([exchangedSides.names]);
  const right = exchanged(picks, exchangedSides.names);
  expect(names(asked(fit, { scan: null, picks: { present: right } }))).toEqual([off.names]);
  expect(names(asked(fit, { scan: null, certain: certainAt(picks, exchangedSides.names) }))).toEqual([off.names]);
});

test("a result that rounds its places, or is of a version that kept none, still asks about the same picks", () => {
  const finer = { ...picks, umbilicus: [0.0001, -200.1234567, 40] as Vector };
  expect(names(asked(ended({ landmarks_not_followed: [off] }, finer), { picks: { present: finer } }))).toEqual([off.names]);
  expect(names(asked({ started: null, picks: null, result: { landmarks_not_followed: [off] } }))).toEqual([off.names]);
});

test("what the start knows is asked while the fit runs, and else what the fit before asked", () => {
  const started = { landmarks_not_followed: [exchangedSides] };
  const before = { ...inMetres(picks), landmarks_unusual: [unusual] };
  expect(names(asked({ started, result: null, picks }))).toEqual([exchangedSides.names]);
  expect(names(asked({ started, result: null, picks, before }))).toEqual([exchangedSides.names]);
  expect(names(asked({ started: {}, result: null, picks, before }))).toEqual([unusual.names]);
  expect(names(asked({ started, result: { landmarks_not_followed: [] }, picks, before }))).toEqual([]);
});

test("sides that lie the wrong way round are asked about before any fit, once, and can be kept", () => {
  const wrong = exchanged(picks, exchangedSides.names);
  const state = asked(null, { picks: { present: wrong } });
  expect(openQuestions(state)).toMatchObject([{ names: ["nipple_L", "nipple_R"], exchange: "sides" }]);
  expect(openQuestions({ ...state, picks: { present: picks } })).toEqual([]);
  expect(openQuestions({ ...state, certain: certainAt(wrong, ["nipple_L", "nipple_R"]) })).toEqual([]);
  expect(names({ ...state, fit: ended({ landmarks_not_followed: [exchangedSides] }, wrong) }), "the fit says it already").toHaveLength(1);
});

test("certain is a pick at its place: it goes with a move and comes back with undo", () => {
  const certain = certainAt(picks, ["umbilicus", "nobody"]);
  expect(certainNames(picks, certain)).toEqual(["umbilicus"]);
  expect(certainNames({ ...picks, umbilicus: [0, -201, 40] }, certain)).toEqual([]);
  expect(certainNames({}, certain)).toEqual([]);
});

test("picks are named by their labels; a name without one stays; a sentence begins with a capital", () => {
  const list = [{ name: "nipple_L", label: "Left nipple" }, { name: "nipple_R", label: "Right nipple" }];
  expect(sentenceOf(exchangedSides, list)).toBe("Left nipple and right nipple look exchanged; they were not followed.");
  expect(sentenceOf({ names: ["nipple_R"], reason: "nipple_R lies where nipple_L is expected." }, list)).toBe("Right nipple lies where left nipple is expected.");
  expect(sentenceOf({ names: ["my_point"], reason: "my_point is 60 mm off." }, list)).toBe("My_point is 60 mm off.");
});
