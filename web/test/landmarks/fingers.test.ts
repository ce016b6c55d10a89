// What a finger on the body means is read off the events' own times: on a busy page timers and events come late and together.
import { afterEach, beforeEach, expect, test, vi } from "vitest";
import type { LandmarkActions } from "../../src/landmarks/actions";
import { listenToFingers } from "../../src/landmarks/fingers";
import type { LandmarksSlice } from "../../src/landmarks/state";
import type { Store } from "../../src/store/store";
import type { Crosshair } from "../../src/viewer/Crosshair";
import type { Viewer } from "../../src/viewer/Viewer";

const POINT = [1, 2, 3];

beforeEach(() => void vi.useFakeTimers());
afterEach(() => void vi.useRealTimers());

function finger() {
  const canvas = new EventTarget() as HTMLElement;
  const viewer = { mayTurn: true };
  const cross = { hit: { point: POINT }, show: vi.fn(), hide: vi.fn() };
  const place = vi.fn();
  const store = { get: () => ({ active: "nipple_L" }) } as Store<LandmarksSlice>;
  const { isAimed } = listenToFingers(canvas, viewer as unknown as Viewer, cross as unknown as Crosshair, store, { place } as unknown as LandmarkActions);
  /** A finger's event of this moment, ms, whenever it arrives. */
  const send = (kind: string, timeStamp: number, clientX = 100): PointerEvent => {
    const event = Object.assign(new Event(kind), { pointerId: 1, pointerType: "touch", isPrimary: true, clientX, clientY: 100 });
    Object.defineProperty(event, "timeStamp", { value: timeStamp });
    canvas.dispatchEvent(event);
    return event as unknown as PointerEvent;
  };
  return { viewer, cross, place, isAimed, send };
}

test("a finger that is held still aims, and lifting it places under the cross", () => {
  const { viewer, cross, place, isAimed, send } = finger();
  send("pointerdown", 1000);
  vi.advanceTimersByTime(400);
  expect([cross.show.mock.lastCall, viewer.mayTurn]).toEqual([[100, 44], false]);
  send("pointermove", 1500, 130);
  expect(cross.show.mock.lastCall).toEqual([130, 44]);
  expect(isAimed(send("pointerup", 1600, 130))).toBe(true);
  expect(place.mock.calls).toEqual([[POINT]]);
  expect(viewer.mayTurn).toBe(true);
});

test("a tap whose lifting arrives after the timer is a tap", () => {
  const { viewer, cross, place, isAimed, send } = finger();
  send("pointerdown", 1000);
  vi.advanceTimersByTime(400);
  expect(isAimed(send("pointerup", 1080))).toBe(false);
  expect(place).not.toHaveBeenCalled();
  expect([cross.hide.mock.calls.length, viewer.mayTurn]).toEqual([1, true]);
});

test("a drag whose moves arrive after the timer turns the body", () => {
  const { viewer, cross, place, isAimed, send } = finger();
  send("pointerdown", 1000);
  vi.advanceTimersByTime(400);
  send("pointermove", 1090, 130);
  expect([cross.hide.mock.calls.length, viewer.mayTurn]).toEqual([1, true]);
  expect(isAimed(send("pointerup", 1900, 160))).toBe(false);
  expect(place).not.toHaveBeenCalled();
});
