import { expect, test } from "vitest";
import { record, redo, startHistory, undo } from "../../src/store/history";

test("undo and redo walk the same way back and forth", () => {
  const history = record(record(startHistory("a"), "b"), "c");
  expect(undo(history).present).toBe("b");
  expect(undo(undo(history)).present).toBe("a");
  expect(redo(undo(history))).toEqual(history);
});

test("at both ends nothing happens", () => {
  const history = startHistory("a");
  expect(undo(history)).toBe(history);
  expect(redo(history)).toBe(history);
});

test("a new step forgets what had been undone", () => {
  const history = record(undo(record(startHistory("a"), "b")), "c");
  expect(history.future).toEqual([]);
  expect(undo(history).present).toBe("a");
});

test("the past is kept to a bounded length", () => {
  let history = startHistory(0);
  for (let i = 1; i <= 1000; i += 1) history = record(history, i);
  expect(history.past.length).toBe(200);
  expect(undo(history).present).toBe(999);
});
