// Lines found on the skin: looked for once, accepted as lines of the plan, renamed, joined, dropped.
import { describe, expect, it } from "vitest";
import type { Ink, Scan, Vector } from "../../src/api/types";
import type { OwnLine } from "../../src/drawing/lines";
import { inkActions } from "../../src/ink/actions";
import { asOwn, nearestJoint, readInk } from "../../src/ink/lines";
import { foundOn, initialInk, mayShowInk } from "../../src/ink/state";
import { initialSession, type Session } from "../../src/app/session";
import { createStore } from "../../src/store/store";

const along = (x: number, from: number, to: number): Vector[] => Array.from({ length: Math.abs(to - from) + 1 }, (_, i): Vector => [x, from + Math.sign(to - from) * i, 0]);
const shape = (points: Vector[], more: Partial<Ink["shapes"][number]> = {}): Ink["shapes"][number] => ({ name: "ink_1", closed: false, color: "#1f49a5", points, kind: "line", marker: "blue", length_mm: points.length - 1, ...more });
const FOUND: Ink = {
  schema: "breastrig/drawing@1",
  unit: "mm",
  shapes: [shape(along(0, 0, 100)), shape(along(0, 140, 104)), shape(along(50, 0, 20), { kind: "cross", marker: "red" }), shape([[0, 0, 9], [9, 0, 9], [9, 9, 9]], { closed: true, kind: "closed" })],
};
const SCAN = { id: "a", colours: "texture", triangles: 1000, bounds_m: { min: [0, 0, 0], max: [0.4, 0.5, 0.3] } } as unknown as Scan;

function page(answers: (Ink | { retryAfterS: number })[], info: Scan = SCAN) {
  const store = createStore<Session>({ ...initialSession, scan: { info } as Session["scan"] });
  const adopted: OwnLine[][] = [];
  let asked = 0;
  const client = { ink: () => Promise.resolve(answers[Math.min(asked++, answers.length - 1)]!) };
  const actions = inkActions(store, client, { adopt: (lines) => void adopted.push([...lines]) });
  const names = (): string[] => foundOn(store.get().ink, info.id).map(({ name }) => name);
  return { store, actions, adopted, names, asked: () => asked };
}

describe("reading", () => {
  it("names lines by marker and kind", () => {
    expect(readInk(FOUND, []).map(({ name }) => name)).toEqual(["Blue line 1", "Blue line 2", "Red cross 1", "Blue closed line 1"]);
  });

  it("leaves out what is a line of the plan already", () => {
    const [first] = readInk(FOUND, []);
    const planned = { ...asOwn(first!), name: "Midline" };
    expect(readInk(FOUND, [planned]).map(({ name }) => name)).toEqual(["Blue line 2", "Red cross 1", "Blue closed line 1"]);
  });

  it("makes lines of the pen: two millimetres from point to point, a closed one without its start again", () => {
    const [open, , , closed] = readInk(FOUND, []);
    expect(asOwn(open!).points).toHaveLength(51);
    expect(asOwn(open!).points.at(-1)).toEqual([0, 100, 0]);
    const round = asOwn(closed!);
    expect(round.closed).toBe(true);
    expect(round.points.at(-1)).not.toEqual(round.points[0]);
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

  it("accepts all lines at once, and marks one by one", async () => {
    const { actions, adopted, names } = page([FOUND]);
    await actions.look();
    actions.acceptAll();
    expect(adopted.map((lines) => lines.map(({ name }) => name))).toEqual([["Blue line 1", "Blue line 2", "Blue closed line 1"]]);
    expect(names()).toEqual(["Red cross 1"]);
    actions.accept("Red cross 1");
    expect(names()).toEqual([]);
    expect(adopted).toHaveLength(2);
    actions.acceptAll();
    expect(adopted).toHaveLength(2);
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
    const { store, actions, names } = page([FOUND]);
    await actions.look();
    const lines = foundOn(store.get().ink, "a");
    expect(nearestJoint(lines[0]!, lines)!.gapMm).toBe(4);
    actions.join("Blue line 1");
    expect(names()).toEqual(["Blue line 1", "Red cross 1", "Blue closed line 1"]);
    const joined = foundOn(store.get().ink, "a")[0]!;
    expect([joined.points[0], joined.points.at(-1)]).toEqual([[0, 0, 0], [0, 140, 0]]);
    expect(joined.lengthMm).toBe(136);
    expect(nearestJoint(lines[3]!, lines)).toBeNull();
  });
});
