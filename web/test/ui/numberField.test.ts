import { expect, test, vi } from "vitest";
import { inLanguage } from "../english";
import { numberField, readNumber, writtenNumber } from "../../src/ui/NumberField";

const mm = { label: "From the nipple", unit: "mm", min: 0, max: 200 };
const hour = { label: "Hour", unit: "h", min: 0.5, max: 12.5 };

test.each([
  ["4,5", 4.5],
  ["4.5", 4.5],
  ["43,5", 43.5],
  [" 45 mm", 45],
  [",5", 0.5],
  ["12.34", 12.34],
  ["0.125", 0.125],
  ["0,125", 0.125],
  ["12.3456", 12.3456],
])("%s mm is %d", (written, value) => expect(readNumber(written, mm)).toBe(value));

// Neither a thousand nor decimals is guessed, in any language: both mistakes are large, and the number is typed again at once.
test.each(["1,234.5", "1.234,5", "1,234", "1.234", "12.345", "-1.234", "1.2.3"])("%s can be read in two ways", (written) => expect(readNumber(written, mm)).toContain("two ways"));

test.each([
  ["abc", "is no number"],
  ["4e1", "is no number"],
  ["10:30", "is no number"],
  ["201", "between 0 and 200 mm"],
  ["-1", "between 0 and 200 mm"],
])("%s mm is refused", (written, sentence) => expect(readNumber(written, mm)).toContain(sentence));

test.each([
  ["10:30", 10.5],
  ["10.5", 10.5],
  ["10,5", 10.5],
  ["10½", 10.5],
  ["10", 10],
  ["12:20", 12.33],
])("%s on the clock is %d", (written, value) => expect(readNumber(written, hour)).toBe(value));

test("what the clock has not is refused", () => {
  for (const written of ["13", "10:75", "half past ten", "0:10"]) expect(readNumber(written, hour)).toEqual(expect.any(String));
});

test("a number is written as it is read again", () => {
  expect([10.5, 12, 12.33, 0.5].map((value) => writtenNumber(value, "h"))).toEqual(["10:30", "12", "12:20", "0:30"]);
  expect([41.999999, 0, -3.5, 1 / 3].map((value) => writtenNumber(value, "mm"))).toEqual(["42", "0", "-3.5", "0.33"]);
  for (const value of [10.5, 12.33, 0.5]) expect(readNumber(writtenNumber(value, "h"), hour)).toBe(value);
});

test("in German a number has a comma, is read again as it is written, and an hour may be said by its word", () =>
  inLanguage("de", () => {
    expect([3.5, 1 / 3, -0.004, 1234.5].map((value) => writtenNumber(value, "mm"))).toEqual(["3,5", "0,33", "0", "1234,5"]);
    for (const value of [3.5, 1234.5, 0.25]) expect(readNumber(writtenNumber(value, "mm"), { ...mm, max: 2000 })).toBe(value);
    expect(writtenNumber(10.5, "h")).toBe("10:30");
    expect([readNumber("10:30", hour), readNumber("2 Uhr", hour), readNumber("2 o'clock", hour)]).toEqual([10.5, 2, 2]);
    expect(readNumber("1.234", mm)).toContain("auf zwei Arten");
    expect(readNumber("201,5", mm)).toBe("From the nipple muss zwischen 0 und 200 mm liegen.");
  }));

/** As much of an element as a field needs. */
class Fake {
  value = "";
  textContent = "";
  hidden = false;
  readonly dataset = {};
  readonly validity = { valid: true };
  readonly children: Fake[] = [];
  private readonly listeners: Record<string, () => void> = {};
  append = (...children: Fake[]): void => void this.children.push(...children);
  addEventListener = (name: string, listener: () => void): void => void (this.listeners[name] = listener);
  setAttribute(name: string): void {
    if (name === "hidden") this.hidden = true;
  }
  setCustomValidity = (says: string): void => void (this.validity.valid = says === "");
  writes(text: string): void {
    this.value = text;
    this.listeners.change!();
  }
}

test("what is refused stays with its sentence when answers to earlier numbers come, until it is dropped", () => {
  vi.stubGlobal("document", { createElement: () => new Fake(), activeElement: null });
  const accepted: (number | null)[] = [];
  const field = numberField({ ...mm, name: "x", hint: "", mayBeEmpty: true, changed: (value) => accepted.push(value) });
  const [, input, below] = (field.element as unknown as Fake).children as [Fake, Fake, Fake];
  input.writes("45");
  input.writes("450");
  field.set(45);
  expect([input.value, below.textContent, below.hidden, accepted]).toEqual(["450", "From the nipple must lie between 0 and 200 mm.", false, [45]]);
  field.drop();
  expect([input.value, below.hidden]).toEqual(["45", true]);
  field.set(44);
  expect(input.value).toBe("44");
  vi.unstubAllGlobals();
});
