// What the bar on the stage says is shown.
import { expect, test } from "vitest";
import { viewBarShown } from "../../src/fit/state";
import { initialView } from "../../src/viewer/state";

test("where there is nothing to choose between, the bar names what is there: the scan of a fit that cannot be used", () => {
  const scan = { mesh: new ArrayBuffer(0), info: { colours: "none" }, crops: { present: [] } };
  const fitted = (level: string) => ({ state: "done", distances: null, result: { verdict: { level, reasons: [] } } });
  const shown = (part: object) => viewBarShown({ ...initialView, scan, loading: null, fit: null, showDistances: false, showLoose: false, showRelief: false, showColours: false, ...part } as unknown as Parameters<typeof viewBarShown>[0]);
  expect([shown({ fit: fitted("unusable") }), shown({}), shown({ fit: fitted("good") })].map(({ hasOverlays, only }) => hasOverlays || only)).toEqual(["scan", "scan", true]);
  expect(shown({ scan: { ...scan, mesh: null }, fit: fitted("good") })).toMatchObject({ hasOverlays: false, only: "model" });
});
