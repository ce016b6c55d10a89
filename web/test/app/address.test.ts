import { expect, test } from "vitest";
import { fromHash, type PageAddress, toHash } from "../../src/app/address";

const NOTHING: PageAddress = { scan: null, fit: null, step: null, frame: null, other: null, isSecond: false, isComparing: false };

test("scan, fit and a turned body survive the address", () => {
  const place = { ...NOTHING, scan: "a1", fit: "b2", step: "plan", frame: { up: [0, 0, 1], front: [0, -1, 0] } } satisfies PageAddress;
  expect(fromHash(toHash(place))).toEqual(place);
});

test("both stances survive it, and how they are looked at", () => {
  const other = { scan: "c3", fit: "d4", frame: { up: [1, 0, 0], front: [0, 0, 1] } } satisfies PageAddress["other"];
  const place: PageAddress = { ...NOTHING, scan: "a1", fit: "b2", other, isSecond: true, isComparing: true };
  expect(fromHash(toHash(place))).toEqual(place);
  expect(fromHash(toHash({ ...place, scan: null }))).toEqual(NOTHING);
});

test("an empty page has an empty address, and a fit without its scan is not kept", () => {
  expect(toHash({ ...NOTHING, fit: "b2" })).toBe("");
  expect(fromHash("")).toEqual(NOTHING);
});

test("a step that there is not is left out", () => {
  expect(fromHash("#scan=a1&step=points").step).toBe("points");
  expect(fromHash("#scan=a1&step=surgery").step).toBeNull();
});

test("a broken frame in the address is left out", () => {
  expect(fromHash("#scan=a1&up=0_1_x&front=0_0_1").frame).toBeNull();
  expect(fromHash("#scan=a1&up=&front=").frame).toBeNull();
});
