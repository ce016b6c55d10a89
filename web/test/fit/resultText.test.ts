import { expect, test } from "vitest";
import { numbers } from "../../src/fit/text";

test("arms are named by the side that the scan shows", () => {
  expect(numbers.armsOf({ L: 22, R: 25 })).toBe("left 22°, right 25°");
  expect(numbers.armsOf({ R: 25 })).toBe("right 25°");
});
