// Which of several pointers on a tablet is meant: the pen draws, fingers turn, the hand that holds the pen does nothing.
import { expect, test } from "vitest";
import { Palms } from "../../src/drawing/pen/palms";

test("fingers draw as long as no pen was seen, and none after", () => {
  const palms = new Palms();
  expect(palms.down(1, "touch")).toBe(true);
  expect(palms.mayDraw("touch")).toBe(true);
  palms.up(1);
  palms.move(2, "pen"); // it hovers
  expect(palms.mayDraw("touch")).toBe(false);
  expect(palms.down(3, "touch"), "it still turns").toBe(true);
  expect([palms.mayDraw("mouse"), palms.mayDraw("pen")]).toEqual([true, true]);
});

test("fingers draw again when that is wished for, and palms are still rejected", () => {
  const palms = new Palms();
  palms.move(1, "pen");
  palms.fingersDraw = true;
  expect([palms.mayDraw("touch"), palms.areFingersFree]).toEqual([true, false]);
  palms.down(1, "pen");
  expect(palms.down(2, "touch")).toBe(false);
});

test("what touches the glass while the pen is on it means nothing until it is lifted, also when it was there before the pen", () => {
  const palms = new Palms();
  palms.down(1, "touch");
  expect(palms.move(1, "touch")).toBe(true);
  palms.down(2, "pen");
  expect(palms.down(3, "touch")).toBe(false);
  expect([palms.move(1, "touch"), palms.move(2, "pen"), palms.move(3, "touch")]).toEqual([false, true, false]);
  palms.up(2);
  expect(palms.isPenDown).toBe(false);
  expect([palms.move(1, "touch"), palms.move(3, "touch")], "still the same hand").toEqual([false, false]);
  palms.up(1);
  palms.up(3);
  expect(palms.down(4, "touch")).toBe(true);
  expect(palms.move(4, "touch")).toBe(true);
});
