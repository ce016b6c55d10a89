import { expect, test } from "vitest";
import { fromHash, toHash } from "../src/state/address";

test("scan, fit and a turned body survive the address", () => {
  const place = { scan: "a1", fit: "b2", frame: { up: [0, 0, 1], front: [0, -1, 0] } } as never;
  expect(fromHash(toHash(place))).toEqual(place);
});

test("an empty page has an empty address, and a fit without its scan is not kept", () => {
  expect(toHash({ scan: null, fit: "b2", frame: null })).toBe("");
  expect(fromHash("")).toEqual({ scan: null, fit: null, frame: null });
});

test("a broken frame in the address is left out", () => {
  expect(fromHash("#scan=a1&up=0_1_x&front=0_0_1").frame).toBeNull();
  expect(fromHash("#scan=a1&up=&front=").frame).toBeNull();
});
