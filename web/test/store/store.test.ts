import { expect, test, vi } from "vitest";
import { createStore } from "../../src/store/store";

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
