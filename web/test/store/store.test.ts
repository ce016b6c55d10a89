import { expect, test, vi } from "vitest";
import { createStore, fieldsOf, only } from "../../src/store/store";
import { follow } from "../../src/ui/Panel";

test("a listener is called at once and after each change, with the state before it", () => {
  const store = createStore({ count: 1, name: "a" });
  const calls: [number, number][] = [];
  const stop = store.subscribe((state, before) => calls.push([state.count, before.count]));
  store.set({ count: 2 });
  store.set((state) => ({ count: state.count + 1 }));
  stop();
  store.set({ count: 9 });
  expect(calls).toEqual([[1, 1], [2, 1], [3, 2]]);
  expect(store.get()).toEqual({ count: 9, name: "a" });
});

test("a listener that tries to change the state is refused, and the others are still called afterwards", () => {
  const store = createStore({ count: 0 });
  const stop = store.subscribe((state) => {
    if (state.count === 1) store.set({ count: 2 });
  });
  expect(() => store.set({ count: 1 })).toThrow("listener");
  stop();
  const listener = vi.fn();
  store.subscribe(listener);
  store.set({ count: 5 });
  expect(listener).toHaveBeenLastCalledWith({ count: 5 }, { count: 1 });
});

test("who selects parts of the state is called at once and only when one of them is another one", () => {
  const lines = [1, 2];
  const store = createStore({ count: 1, lines, announcement: "" });
  const listener = vi.fn();
  const stop = store.select(only("count", "lines"), listener);
  expect(listener.mock.calls).toEqual([[{ count: 1, lines }, { count: 1, lines }]]);
  store.set({ announcement: "nothing that this one shows" });
  store.set({ lines });
  expect(listener).toHaveBeenCalledTimes(1);
  store.set({ count: 2, announcement: "" });
  expect(listener.mock.lastCall).toEqual([{ count: 2, lines }, { count: 1, lines }]);
  store.set({ lines: [...lines] });
  expect(listener).toHaveBeenCalledTimes(3);
  stop();
  store.set({ count: 3 });
  expect(listener).toHaveBeenCalledTimes(3);
});

test("what is computed from the state counts by its values, not by the object that holds them", () => {
  const store = createStore({ picks: ["a"], distance: Number.NaN });
  const listener = vi.fn();
  store.select(({ picks, distance }) => ({ isEmpty: picks.length === 0, distance }), listener);
  store.set({ picks: ["a", "b"] });
  expect(listener).toHaveBeenCalledTimes(1); // NaN is the same NaN
  store.set({ picks: [] });
  expect(listener.mock.lastCall?.[0]).toEqual({ isEmpty: true, distance: Number.NaN });
});

test("of a part all fields count but those of which nothing is shown, and one that is gone", () => {
  const store = createStore<{ part: { line?: number; saving?: string } }>({ part: { line: 1, saving: "saved" } });
  const listener = vi.fn();
  store.select((state) => fieldsOf(state, "part", "saving"), listener);
  store.set({ part: { line: 1, saving: "waiting" } });
  expect(listener).toHaveBeenCalledTimes(1);
  store.set({ part: { line: 2 } });
  expect(listener).toHaveBeenLastCalledWith({ "part.line": 2 }, { "part.line": 1 });
  store.set({ part: {} });
  expect(listener).toHaveBeenCalledTimes(3);
});

test("a listener that selects must not set either", () => {
  const store = createStore({ count: 0, other: 0 });
  store.select(only("count"), ({ count }) => {
    if (count > 0) store.set({ other: count });
  });
  expect(() => store.set({ count: 1 })).toThrow("listener");
});

test("a panel is brought up to date with what it shows, at once and when that changes", () => {
  const store = createStore({ shown: 1, hidden: 1 });
  const update = vi.fn();
  follow(store, { element: null as unknown as HTMLElement, select: only("shown"), update });
  store.set({ hidden: 2 });
  store.set({ shown: 2 });
  expect(update.mock.calls).toEqual([[{ shown: 1 }], [{ shown: 2 }]]);
});
