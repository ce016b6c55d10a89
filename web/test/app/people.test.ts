// Who is signed in: what a reader may not do, whose typed words wait, which group is asked for, and when nobody is at the page.
import { expect, test, vi } from "vitest";
import type { Caller } from "../../src/api/types";
import { followIdle } from "../../src/app/people/idle";
import { CHANGES } from "../../src/app/people/reader";
import { groupsForNew, isGroupMissing } from "../../src/store/person";
import { createOutbox } from "../../src/store/outbox";
import { page } from "../fakes";

const caller = (part: Partial<Caller> = {}): Caller => ({ id: "1", name: "Rose", role: "look", groups: [], all_groups: [], idle_minutes: null, ...part });

function memoryOf(): Storage {
  const kept = new Map<string, string>();
  return { getItem: (key: string) => kept.get(key) ?? null, setItem: (key: string, value: string) => void kept.set(key, value), removeItem: (key: string) => void kept.delete(key), key: (i: number) => [...kept.keys()][i] ?? null, get length() { return kept.size; }, clear: () => kept.clear() };
}

function pageOf(person: Caller | null) {
  const made = page();
  made.store.set(({ meta }) => ({ meta: { ...meta!, person } }));
  return made;
}

test("each action that changes something says to a reader why it does not", () => {
  const { store, actions } = pageOf(caller());
  for (const [room, names] of Object.entries(CHANGES))
    for (const name of names) {
      const before = store.get();
      store.set({ problems: {} });
      void (actions[room as keyof typeof CHANGES] as unknown as Record<string, () => unknown>)[name]!();
      expect(store.get().problems, `${room}.${name}`).toEqual({ page: "Rose may look at patients, not change them. Ask an administrator of your clinic for more." });
      expect({ ...store.get(), problems: {}, announcement: "" }, `${room}.${name}`).toEqual({ ...before, problems: {}, announcement: "" });
    }
});

test("a planner, and anybody where there are no users, may do all", async () => {
  for (const person of [caller({ role: "plan" }), caller({ role: "administer" }), null]) {
    const { store, actions } = pageOf(person);
    actions.patients.remove("p1");
    expect(store.get().patients.going).toEqual(["p1"]);
    actions.patients.undo("p1");
    await Promise.resolve();
  }
});

test("a person in several groups is asked which one a new patient belongs to, others are not", async () => {
  const { store, actions } = pageOf(caller({ role: "plan", groups: ["north", "south"] }));
  expect([groupsForNew(store.get().meta), isGroupMissing(store.get())]).toEqual([["north", "south"], true]);
  await actions.bring.examples(["standing"]);
  await actions.bring.files([new File([], "scan.ply")]);
  expect(store.get().problems.scan).toContain("choose the one that the new patient belongs to");
  actions.patients.chooseGroup("south");
  expect([isGroupMissing(store.get()), store.get().problems]).toEqual([false, {}]);
  for (const person of [null, caller({ role: "plan", groups: ["north"] }), caller({ role: "administer", all_groups: ["north", "south"] })])
    expect(isGroupMissing(pageOf(person).store.get())).toBe(false);
  expect(groupsForNew(pageOf(caller({ groups: ["north"] })).store.get().meta)).toEqual([]);
});

test("what one person could not save waits for that person, and nobody else sees or sends it", () => {
  const memory = memoryOf();
  const first = createOutbox(memory);
  expect(first.belongTo("anna")).toBe(false);
  first.keep("lines", "s1", "p1", "of Anna");
  const second = createOutbox(memory);
  expect(second.belongTo("bea")).toBe(true);
  expect([second.scans("lines"), second.kept("lines", "s1")]).toEqual([[], null]);
  second.keep("lines", "s2", "p2", "of Bea");
  const third = createOutbox(memory);
  third.belongTo("anna");
  expect([third.scans("lines"), third.kept("lines", "s1")]).toEqual([["s1"], "of Anna"]);
  third.saved("lines", "s1");
  third.belongTo("bea");
  expect(third.kept("lines", "s2")).toBe("of Bea");
});

test("the session is kept while somebody moves, in whichever tab, and left when nobody does", () => {
  const memory = memoryOf();
  const heard = new Map<string, () => void>();
  const stay = vi.fn(() => Promise.resolve());
  const warn = vi.fn();
  const leave = vi.fn();
  let at = 0;
  let look = (): void => undefined;
  const on = { addEventListener: (kind: string, listener: () => void) => void heard.set(kind, listener), setInterval: (every: () => void) => ((look = every), 0) };
  followIdle({ minutes: 15, memory, stay, warn, leave }, on as unknown as Window, () => at);
  const after = (minutes: number): void => {
    at += 60_000 * minutes;
    look();
  };
  heard.get("pointermove")!();
  expect(stay, "just let in").not.toHaveBeenCalled();
  after(2);
  heard.get("keydown")!();
  heard.get("keydown")!();
  expect(stay).toHaveBeenCalledTimes(1);
  after(14.5);
  expect(warn).toHaveBeenLastCalledWith(expect.stringContaining("in one minute"));
  heard.get("wheel")!();
  expect(warn).toHaveBeenLastCalledWith(null);
  after(14);
  memory.setItem("breastrig.at-page", String(at)); // in another tab
  after(13);
  expect(leave).not.toHaveBeenCalled();
  after(2);
  expect(leave).toHaveBeenCalled();
});
