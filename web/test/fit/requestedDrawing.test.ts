// Pattern and tumour as one text.
import { expect, test } from "vitest";
import type { PatternInfo, PatternParameter } from "../../src/api/types";
import { areApart, mirroredValues, readRequest, requestText, setApart, setTogether, startValue, stillNeeded, valueOn } from "../../src/fit/requestedDrawing";

const parameter = (part: Partial<PatternParameter>): PatternParameter => ({ name: "areola_mm", label: "New areola", about: "", unit: "mm", default: 42, needed: false, min: 30, max: 55, choices: null, ...part });

test("a request is written as the service reads it, and read again", () => {
  const request = { base: "reduction", values: { side: "L", areola_mm: "45" }, tumour: { side: "R", clock: "10.5", distance_mm: "45", radius_mm: "12" } };
  expect(requestText(request)).toBe("reduction:side=L,areola_mm=45+tumour:side=R,clock=10.5,distance_mm=45,radius_mm=12");
  expect(readRequest(requestText(request))).toEqual(request);
});

test("defaults are left out, and nothing is asked for by an empty text", () => {
  expect(requestText({ base: "reduction", values: { limb_mm: "" }, tumour: null })).toBe("reduction");
  expect(requestText({ base: "", values: {}, tumour: null })).toBe("");
  expect(readRequest("")).toEqual({ base: "", values: {}, tumour: null });
  expect(readRequest("lumpectomy")).toEqual({ base: "lumpectomy", values: {}, tumour: null });
});

test("what is needed starts without a value: nobody guesses a patient's tumour", () => {
  const pattern: PatternInfo = { name: "tumour", label: "Tumour", parameters: [parameter({ name: "side", default: null, needed: true, choices: ["L", "R"] }), parameter({ name: "clock", default: null, needed: true }), parameter({})] };
  expect(pattern.parameters.map(startValue)).toEqual(["", "", "42"]);
  expect(stillNeeded(pattern, {}).map(({ name }) => name)).toEqual(["side", "clock"]);
  expect(stillNeeded(pattern, { side: "L", clock: "" }).map(({ name }) => name)).toEqual(["clock"]);
  expect(stillNeeded(pattern, { side: "L", clock: "10" })).toEqual([]);
});

test("on the other side a tumour's hour is exchanged as well; what is on both sides has no other", () => {
  expect(mirroredValues({ side: "L", clock: "10", distance_mm: "45", radius_mm: "12" })).toEqual({ side: "R", clock: "2", distance_mm: "45", radius_mm: "12" });
  const hour = (clock: string): string => mirroredValues({ side: "R", clock })!.clock!;
  expect(["12", "6", "3", "0.5", "11.5", "12.5", "11.75", "1.25"].map(hour)).toEqual(["12", "6", "9", "11.5", "0.5", "11.5", "12.25", "10.75"]);
  expect(mirroredValues({ side: "R", limb_mm: "50" })).toEqual({ side: "L", limb_mm: "50" });
  expect(mirroredValues({ side: "both" })).toBeNull();
  expect(mirroredValues({})).toBeNull();
});

test("right and left are set apart with what each has now, and put together as one of them has it", () => {
  const all = [parameter({ name: "side", default: "both", choices: ["both", "L", "R"] }), parameter({}), parameter({ name: "limb_mm", default: null })];
  const values = { side: "both", areola_mm: "40" };
  expect(areApart(values)).toBe(false);
  const apart = setApart(values, all);
  const text = requestText({ base: "reduction", values: apart, tumour: null });
  expect(text, "what is chosen by itself stays so").toBe("reduction:side=both,areola_mm_right=40,areola_mm_left=40");
  const changed = { ...readRequest(text).values, areola_mm_left: "36", limb_mm_right: "45" };
  expect(areApart(changed)).toBe(true);
  expect(all.slice(1).map((each) => [valueOn(changed, each, "R"), valueOn(changed, each, "L")])).toEqual([["40", "36"], ["45", ""]]);
  expect(valueOn({ areola_mm: "44", areola_mm_left: "36" }, all[1]!, "R"), "one number for the other side").toBe("44");
  expect(setTogether(changed, all, "R")).toEqual({ side: "both", areola_mm: "40", limb_mm: "45" });
  expect(setTogether({ areola_mm_left: "42", areola_mm_right: "40" }, all, "L"), "a default is left out").toEqual({});
});
