// Lines found on the skin: looked for once, accepted as lines of the plan, renamed, joined, dropped.
import { describe, expect, it } from "vitest";
import { ApiError } from "../../src/api/client";
import type { Ink, Scan, Vector } from "../../src/api/types";
import { drawingActions } from "../../src/drawing/actions";
import { startDrawn } from "../../src/drawing/state";
import { inkActions } from "../../src/ink/actions";
import { asOwn, decidedBefore, nearestJoint, readInk } from "../../src/ink/lines";
import { initialInk, openLines } from "../../src/ink/state";
import { mayShowInk } from "../../src/scan/fineColours";
import { initialSession, type Session } from "../../src/app/session";
import { cropsOf } from "../../src/scan/crop";
import { linesOn, withLines } from "../../src/plan/items";
import { startHistory } from "../../src/store/history";
import { createStore } from "../../src/store/store";

const along = (x: number, from: number, to: number): Vector[] => Array.from({ length: Math.abs(to - from) + 1 }, (_, i): Vector => [x, from + Math.sign(to - from) * i, 0]);
const shape = (points: Vector[], more: Partial<Ink["shapes"][number]> = {}): Ink["shapes"][number] => ({ name: "ink_1", closed: false, color: "#1f49a5", points, kind: "line", marker: "blue", length_mm: points.length - 1, ...more });
const FOUND: Ink = {
  schema: "breastrig/drawing@1",
  unit: "mm",
  shapes: [shape(along(0, 0, 100)), shape(along(0, 140, 104)), shape(along(50, 0, 20), { kind: "cross", marker: "red" }), shape([[0, 0, 9], [9, 0, 9], [9, 9, 9]], { closed: true, kind: "closed" })].map((each, i) => ({ ...each, name: `ink_${i + 1}` })),
};
const SCAN = { id: "a", colours: "texture", triangles: 1000, bounds_m: { min: [0, 0, 0], max: [0.4, 0.5, 0.3] } } as unknown as Scan;

function page(answers: (Ink | { retryAfterS: number })[], info: Scan = SCAN) {
  const store = createStore<Session>({ ...initialSession, scan: { info } as Session["scan"] });
  const sent: Record<string, boolean>[] = [];
  let asked = 0;
  let isBroken = false;
  const client = {
    ink: () => Promise.resolve(answers[Math.min(asked++, answers.length - 1)]!),
    dropInk: (_scan: Scan, dropped: Readonly<Record<string, boolean>>) => {
      if (isBroken) return Promise.reject(new ApiError("The service is busy.", 503));
      sent.push({ ...dropped });
      return Promise.resolve(FOUND);
    },
  };
  const lengths = () => Promise.reject(new ApiError("There is no fit.", 404));
  const plan = { save: () => Promise.resolve(), earlier: () => Promise.resolve(null) };
  const drawing = drawingActions(store, { lengths }, plan);
  const actions = inkActions(store, client, drawing);
  const lines = () => openLines(store.get().ink[info.id], store.get().drawn.decided, cropsOf(store.get().scan));
  const names = (): string[] => lines().map(({ name }) => name);
  const planned = (): string[] => store.get().drawn.lines.present.map(({ name }) => name);
  return { store, actions, drawing, sent, lines, names, planned, asked: () => asked, breakDown: (is: boolean) => void (isBroken = is) };
}

describe("reading", () => {
  it("names lines by marker and kind", () => {
    expect(readInk(FOUND).map(({ name }) => name)).toEqual(["Blue line 1", "Blue line 2", "Red cross 1", "Blue closed line 1"]);
  });

  it("knows what is decided: a line of the plan already, and what the service keeps as dropped", () => {
    const found = readInk(FOUND);
    const planned = { ...asOwn(found[0]!), name: "Midline" };
    expect(decidedBefore(found, ["ink_3"], [planned])).toEqual({ ink_1: "accepted", ink_3: "dropped" });
    expect(decidedBefore(found, ["ink_1"], [planned])).toEqual({ ink_1: "accepted" });
    const { ink: _, ...older } = planned;
    expect(decidedBefore(found, [], [older])).toEqual({ ink_1: "accepted" });
  });

  it("knows a line of the plan however it was changed, also after the plan was stored", () => {
    const found = readInk(FOUND);
    const own = asOwn(found[0]!);
    const changed = { ...own, name: "Midline", points: own.points.map(([x, y, z]): Vector => [x + 30, y, z]) };
    const stored = linesOn(withLines([], "s1", [changed]), "s1");
    expect(decidedBefore(found, [], stored)).toEqual({ ink_1: "accepted" });
    expect(decidedBefore(found, [], [])).toEqual({});
  });

  it("makes lines of the pen: two millimetres from point to point, a closed one without its start again", () => {
    const [open, , , closed] = readInk(FOUND);
    expect(asOwn(open!).points).toHaveLength(51);
    expect(asOwn(open!).points.at(-1)).toEqual([0, 100, 0]);
    const round = asOwn(closed!);
    expect(round.closed).toBe(true);
    expect(round.points.at(-1)).not.toEqual(round.points[0]);
  });

  it("says which parts of a line are guessed: over a hole of the scan, and over a gap that a person has joined", () => {
    const bridged = along(0, 0, 100).map(([, y]) => y > 39.5 && y < 60.5);
    const [over, beyond] = readInk({ ...FOUND, shapes: [shape(along(0, 0, 100), { bridged }), shape(along(0, 130, 230))] });
    const own = asOwn(over!);
    expect(own.points.filter((_, i) => own.bridged![i]).map(([, y]) => y)).toEqual([40, 42, 44, 46, 48, 50, 52, 54, 56, 58, 60]);
    expect("bridged" in asOwn(beyond!)).toBe(false);
    const joint = nearestJoint(over!, [over!, beyond!])!;
    const both = asOwn({ ...over!, points: joint.points, bridged: joint.bridged });
    const guessed = both.points.filter((_, i) => both.bridged![i]).map(([, y]) => y);
    expect(guessed.filter((y) => y < 80)).toEqual([40, 42, 44, 46, 48, 50, 52, 54, 56, 58, 60]);
    expect(guessed.filter((y) => y > 80)).toEqual([102, 104, 106, 108, 110, 112, 114, 116, 118, 120, 122, 124, 126, 128]);
    const round = readInk({ ...FOUND, shapes: [shape([[0, 0, 0], [20, 0, 0], [20, 20, 0], [0, 20, 0]], { closed: true, bridged: [false, false, true, true] })] })[0]!;
    const closed = asOwn(round);
    expect([closed.bridged!.length, closed.points.length]).toEqual([40, 40]);
    expect(closed.points.filter((_, i) => !closed.bridged![i])).toEqual([[0, 0, 0], [20, 0, 0]]); // long steps are gaps as well
  });

  it("knows which scans may show a pen's line", () => {
    expect(mayShowInk(SCAN)).toBe(true);
    expect(mayShowInk({ ...SCAN, colours: "none" })).toBe(false);
    expect(mayShowInk({ ...SCAN, colours: "vertex", triangles: 60_000 })).toBe(false);
    expect(mayShowInk({ ...SCAN, colours: "vertex", triangles: 2_000_000 })).toBe(true);
  });
});

describe("deciding", () => {
  it("looks once, also when the service needs a second, and says what it found", async () => {
    const { store, actions, names, asked } = page([{ retryAfterS: 0.001 }, FOUND]);
    await Promise.all([actions.look(), actions.look()]);
    expect(names()).toHaveLength(4);
    expect(asked()).toBe(2);
    expect(store.get().announcement).toBe("4 lines found on the skin.");
  });

  it("does not ask for a scan without colours", async () => {
    const { store, actions, asked } = page([FOUND], { ...SCAN, colours: "none" });
    await actions.look();
    expect(asked()).toBe(0);
    expect(store.get().ink).toEqual(initialInk.ink);
  });

  it("shows and accepts no line that lies for the most part in what is cut away, until the cut is taken back", async () => {
    const { store, actions, names, planned } = page([FOUND]);
    await actions.look();
    const above = (y: number): void => store.set(({ scan }) => ({ scan: { ...scan!, crops: startHistory([{ toPicture: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1], lasso: [[-1, y], [1, y], [1, 1], [-1, 1]] }]) } }));
    above(0.08); // metres: a fifth of the first line lies there, and all of the second
    expect(names()).toEqual(["Blue line 1", "Red cross 1", "Blue closed line 1"]);
    actions.acceptAll();
    expect(planned()).toEqual(["Blue line 1", "Blue closed line 1"]);
    above(0.2);
    expect(names()).toEqual(["Blue line 2", "Red cross 1"]);
  });

  it("accepts all lines at once, and marks one by one", async () => {
    const { store, actions, names, planned } = page([FOUND]);
    await actions.look();
    actions.acceptAll();
    expect(planned()).toEqual(["Blue line 1", "Blue line 2", "Blue closed line 1"]);
    expect(names()).toEqual(["Red cross 1"]);
    actions.accept("Red cross 1");
    expect(names()).toEqual([]);
    expect(planned()).toHaveLength(4);
    const { past } = store.get().drawn.lines;
    actions.acceptAll();
    expect(store.get().drawn.lines.past).toBe(past);
  });

  it("renames where the name is free, drops, and drops the rest", async () => {
    const { actions, names } = page([FOUND]);
    await actions.look();
    expect(actions.rename("Blue line 1", "Midline")).toBe(true);
    expect(actions.rename("Blue line 2", "Midline")).toBe(false);
    actions.drop("Red cross 1");
    expect(names()).toEqual(["Midline", "Blue line 2", "Blue closed line 1"]);
    actions.dropAll();
    expect(names()).toEqual([]);
  });

  it("joins a line with the one whose end is nearest, the right way round", async () => {
    const { actions, lines: open, names, planned, sent } = page([FOUND]);
    await actions.look();
    const lines = open();
    expect(nearestJoint(lines[0]!, lines)!.gapMm).toBe(4);
    actions.join("Blue line 1");
    expect(names()).toEqual(["Blue line 1", "Red cross 1", "Blue closed line 1"]);
    const joined = open()[0]!;
    expect([joined.points[0], joined.points.at(-1)]).toEqual([[0, 0, 0], [0, 140, 0]]);
    expect(joined.lengthMm).toBe(136);
    expect(nearestJoint(lines[3]!, lines)).toBeNull();
    actions.drop("Blue line 1");
    await actions.settled();
    expect(sent).toEqual([{ ink_1: true, ink_2: true }]);
    expect([names(), planned()]).toEqual([["Red cross 1", "Blue closed line 1"], []]);
  });

  it("keeps what was dropped at the service, and a page that is opened again leaves it out", async () => {
    const { store, actions, names, sent } = page([FOUND]);
    await actions.look();
    actions.drop("Blue line 2");
    actions.dropAll();
    await actions.settled();
    expect(sent).toEqual([{ ink_2: true }, { ink_1: true, ink_3: true, ink_4: true }]);
    expect(names()).toEqual([]);

    const later = page([{ ...FOUND, shapes: FOUND.shapes.map((each) => ({ ...each, dropped: each.name === "ink_2" })) }]);
    await later.actions.look();
    expect(later.names()).toEqual(["Blue line 1", "Red cross 1", "Blue closed line 1"]);
    expect(later.store.get().announcement).toBe("3 lines found on the skin.");
    expect(later.sent).toEqual([]);
    later.actions.bringBack();
    await later.actions.settled();
    expect(later.names()).toHaveLength(4);
    expect(later.sent).toEqual([{ ink_2: false }]);

    store.set(({ drawn }) => ({ drawn: startDrawn(drawn.lines.present) })); // the scan is left and opened again on this page
    expect(names()).toEqual([]);
    await actions.look();
    expect(names()).toEqual([]);
    expect(Object.keys(store.get().drawn.decided!)).toHaveLength(4);
  });

  it("brings back by undo what was dropped or accepted, at the service too, and takes it away by redo", async () => {
    const { actions, drawing, names, planned, sent } = page([FOUND]);
    await actions.look();
    actions.accept("Blue line 1");
    actions.drop("Blue line 2");
    expect(names()).toEqual(["Red cross 1", "Blue closed line 1"]);
    drawing.undo();
    expect([names(), planned()]).toEqual([["Blue line 2", "Red cross 1", "Blue closed line 1"], ["Blue line 1"]]);
    drawing.undo();
    expect([names(), planned()]).toEqual([["Blue line 1", "Blue line 2", "Red cross 1", "Blue closed line 1"], []]);
    drawing.redo();
    drawing.redo();
    expect([names(), planned()]).toEqual([["Red cross 1", "Blue closed line 1"], ["Blue line 1"]]);
    await actions.settled();
    expect(sent).toEqual([{ ink_2: true }, { ink_2: false }, { ink_2: true }]);
  });

  it("says when a drop could not be kept, and sends it with the next one", async () => {
    const { store, actions, names, sent, breakDown } = page([FOUND]);
    await actions.look();
    breakDown(true);
    actions.drop("Blue line 1");
    await actions.settled();
    expect(store.get().problems.drawing).toBe("The service is busy.");
    expect(names()).not.toContain("Blue line 1");
    breakDown(false);
    actions.drop("Red cross 1");
    await actions.settled();
    expect(sent).toEqual([{ ink_1: true, ink_3: true }]);
    expect(store.get().problems.drawing).toBeUndefined();
  });
});
