import { expect, test } from "vitest";
import { keepAddress, takeAddress } from "../../src/app/unsavedWork";
import { memory } from "../fakes";

test("after signing in again the page is where it was, once", () => {
  const here = memory();
  keepAddress("#scan=s1&fit=f1", here);
  expect(takeAddress(here)).toBe("#scan=s1&fit=f1");
  expect(takeAddress(here)).toBeNull();
});
