import { expect, test } from "vitest";
import { initialSession, type Session } from "../../src/app/session";
import { keepUnsaved, takeUnsaved } from "../../src/app/unsavedWork";
import { startDrawn } from "../../src/drawing/state";
import { startHistory } from "../../src/store/history";

function memory() {
  const kept = new Map<string, string>();
  return {
    getItem: (key: string) => kept.get(key) ?? null,
    setItem: (key: string, value: string) => void kept.set(key, value),
    removeItem: (key: string) => void kept.delete(key),
  };
}

const state = { ...initialSession, scan: { info: { id: "s1" } }, picks: startHistory({ nipple_L: [1, 2, 3] }) } as unknown as Session;

test("after signing in again the page is where it was, with the landmarks that could not be saved, once", () => {
  const here = memory();
  keepUnsaved({ ...state, saving: "unsaved" }, "#scan=s1&fit=f1", here);
  expect(takeUnsaved(here)).toEqual({ hash: "#scan=s1&fit=f1", unsaved: { scan: "s1", picks: { nipple_L: [1, 2, 3] }, certain: [] } });
  expect(takeUnsaved(here)).toBeNull();
});

test("lines that could not be saved wait as well", () => {
  const here = memory();
  const line = { name: "Line 1", closed: false, color: "#101010", points: [[0, 0, 0], [2, 0, 0]] as [number, number, number][], corners: [0, 1] };
  keepUnsaved({ ...state, drawn: { ...startDrawn([line]), saving: "unsaved" } }, "#scan=s1", here);
  expect(takeUnsaved(here)).toEqual({ hash: "#scan=s1", unsaved: { scan: "s1", lines: [line] } });
});

test("what the service has is not kept in the browser", () => {
  const here = memory();
  keepUnsaved(state, "#scan=s1", here);
  expect(takeUnsaved(here)).toEqual({ hash: "#scan=s1", unsaved: null });
});
