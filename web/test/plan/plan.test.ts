// The plan: which items are of which scan, changes put back without losing ids, and two tabs that write at the same time.
import { afterEach, beforeEach, expect, test, vi } from "vitest";
import { fakePlans, fitLinks, page, scanInfo } from "../fakes";
import { ApiError } from "../../src/api/client";
import type { Fit, PlanItem, Scan, StoredPlan } from "../../src/api/types";
import { lineAlong } from "../../src/drawing/lines/edits";
import type { OwnLine } from "../../src/drawing/lines/lines";
import { readDrawing, toText } from "../../src/drawing/lines/files";
import { depthOn, drawingOn, linesOn, merged, noteOn, stepOn, stepTogether, timesLarger, withDepth, withDrawing, withLines, withNote } from "../../src/plan/items";
import { createPlanKeeper } from "../../src/plan/keeper";
import { type Workspace, workspaceOf } from "../../src/stances/state";

const line = (id: string, name: string, scan = "s1", x = 0): PlanItem => ({ kind: "line", id, scan, name, label: "", closed: false, color: "#101010", points: [[x, 0, 0], [x + 10, 0, 0]] });
const note = (id: string, text: string): PlanItem => ({ kind: "note", id, scan: "s1", text });
const ITEMS: PlanItem[] = [
  line("a", "Line 1"),
  { kind: "pattern", id: "p", scan: "s1", name: "reduction", parameters: { side: "L", areola_mm: 40 } },
  { kind: "tumour", id: "t", scan: "s1", side: "L", clock: 10.5, distance_mm: 45, radius_mm: 12, depth_mm: 20 },
  note("n", "smaller"),
  line("b", "Line 1", "s2"),
];
const TEXT = "reduction:side=L,areola_mm=40+tumour:side=L,clock=10.5,distance_mm=45,radius_mm=12";
const ids = (items: readonly PlanItem[]): string[] => items.map(({ id }) => id);

test("a scan has its lines and the text that its fit is asked with", () => {
  expect(linesOn(ITEMS, "s2").map(({ id, name }) => [id, name])).toEqual([["b", "Line 1"]]);
  expect(drawingOn(ITEMS, "s1")).toBe(TEXT);
  expect(drawingOn(ITEMS, "s2")).toBe("");
});

test("a line says which of its points are guessed, in the plan and back from it", () => {
  const bridged = [false, true, true, false];
  const guessed = lineAlong("ink", "#1f49a5", [[0, 0, 0], [2, 0, 0], [4, 0, 0], [6, 0, 0]], false, bridged);
  const items = withLines([], "s1", [guessed, lineAlong("pen", "#101010", [[0, 9, 0], [2, 9, 0]], false)]);
  expect(items.map((item) => ("bridged" in item ? item.bridged : null))).toEqual([bridged, null]);
  expect(linesOn(items, "s1").map((each) => each.bridged)).toEqual([bridged, undefined]);
  expect(readDrawing(toText(linesOn(items, "s1")), "mm").map((each) => each.bridged)).toEqual([bridged, undefined]);
});

test("what is put back keeps its ids, and what the page does not edit stays", () => {
  const lines = [...linesOn(ITEMS, "s1").map((each) => ({ ...each, name: "incision" })), lineAlong("new", "#101010", [[0, 0, 0]], false)];
  const after = withLines(ITEMS, "s1", lines);
  expect(ids(after).slice(0, 5)).toEqual(["p", "t", "n", "b", "a"]);
  expect(after.at(-1)!.id).toMatch(/^[A-Za-z0-9_-]{8,64}$/);
  const changed = withDrawing(ITEMS, "s1", TEXT.replace("clock=10.5", "clock=9").replace("reduction:side=L,", "reduction:side=R,"));
  expect(changed.find(({ id }) => id === "t")).toMatchObject({ clock: 9, depth_mm: 20 });
  expect(changed.find(({ id }) => id === "p")).toMatchObject({ parameters: { side: "R", areola_mm: 40 } });
  expect(withDrawing(ITEMS, "s1", TEXT).map((item) => ITEMS.includes(item) || item.id), "what says the same already is left as it is").toEqual([true, true, true, true, true]);
  expect(ids(withDrawing(ITEMS, "s1", ""))).toEqual(["a", "n", "b"]);
  expect(ids(withDrawing([], "s2", "lumpectomy"))).toHaveLength(1);
});

test("note and depth belong to one scan, and go when they are emptied", () => {
  expect([noteOn(ITEMS, "s1"), noteOn(ITEMS, "s2"), depthOn(ITEMS, "s1"), depthOn(ITEMS, "s2")]).toEqual(["smaller", "", 20, null]);
  expect(withNote(ITEMS, "s1", " larger ").at(-1)).toEqual(note("n", "larger"));
  expect(ids(withNote(ITEMS, "s1", " "))).toEqual(["a", "p", "t", "b"]);
  const placed: PlanItem = { ...note("q", "here"), kind: "note", text: "here", point: [1, 2, 3] };
  expect(noteOn([placed], "s1")).toBe("");
  expect(depthOn(withDepth(ITEMS, "s1", 31), "s1")).toBe(31);
  expect(withDepth(ITEMS, "s2", 31)).toEqual(ITEMS);
});

test("two who change different things get both; one thing changed twice is kept twice; nothing that was changed is deleted", () => {
  const mine = [line("a", "mine"), ...ITEMS.slice(1, 3), line("c", "Line 2")]; // changed a, deleted n and b, added c
  const theirs = [ITEMS[0]!, ITEMS[1]!, ITEMS[2]!, note("n", "larger"), line("b", "Line 1", "s2"), line("d", "Line 2")];
  expect(merged(ITEMS, mine, theirs).map(({ id, ...rest }) => [id, "name" in rest ? rest.name : "text" in rest ? rest.text : rest.kind])).toEqual([
    ["a", "mine"], ["p", "reduction"], ["t", "tumour"], ["n", "larger"], ["d", "Line 2"], ["c", "Line 2 2"],
  ]);
  const both = merged([line("a", "x")], [line("a", "x", "s1", 5)], [line("a", "x", "s1", 7)]);
  expect(both.map((item) => (item.kind === "line" ? [item.name, item.points[0]![0]] : null))).toEqual([["x", 5], ["x 2", 7]]);
  expect(merged(ITEMS, ITEMS, [])).toEqual([]);
  expect(merged(ITEMS, [], ITEMS)).toEqual([]);
  expect(ids(merged([note("n", "a")], [note("n", "b")], []))).toEqual(["n"]);
});

test("two tabs: the second reads the plan again and takes its change over", async () => {
  const client = fakePlans();
  const told = vi.fn();
  const [one, other] = [createPlanKeeper(client, told), createPlanKeeper(client, told)];
  await Promise.all([one.read("p"), other.read("p")]);
  const [first, second] = [line("a", "first"), line("b", "second")];
  await one.save("p", (items) => [...items, first]);
  expect(told).not.toHaveBeenCalled();
  await other.save("p", (items) => [...items, second]);
  expect(told.mock.calls).toEqual([["p", { items: [second], whole: false }, [first, second], { base: [], mine: [second], theirs: [first] }]]);
  expect(ids(other.seen("p")!.items)).toEqual(["a", "b"]);
  expect((await client.plan("p")).version).toBe(2);
});

test("two who begin or change the one pattern, tumour or note of a scan: both texts stay, and of the numbers it is said what had to give way", () => {
  const pattern = (id: string, mm: number): PlanItem => ({ kind: "pattern", id, scan: "s1", name: "reduction", parameters: { areola_mm: mm } });
  const tumour = (id: string, clock: number): PlanItem => ({ kind: "tumour", id, scan: "s1", side: "L", clock, distance_mm: 45, radius_mm: 12 });
  expect(merged([], [note("n", "mine"), pattern("p", 40)], [note("m", "theirs"), pattern("q", 42)])).toEqual([note("m", "mine\ntheirs"), pattern("q", 40)]);
  const base = [pattern("p", 40), tumour("t", 10)];
  const step = stepOn([pattern("p", 44), tumour("t", 10)], "s1");
  const both = stepTogether(base, step, [pattern("p", 40), tumour("t", 3)], "s1");
  expect(both, "one changed the pattern, the other the tumour: nothing has to give way").toEqual({ step: { ...step, drawing: "reduction:areola_mm=44+tumour:side=L,clock=3,distance_mm=45,radius_mm=12" }, contested: null });
  const asked = stepTogether(base, step, [pattern("p", 42), tumour("t", 10)], "s1");
  expect(asked).toEqual({ step, contested: { drawing: "reduction:areola_mm=42+tumour:side=L,clock=10,distance_mm=45,radius_mm=12", depthMm: null } });
});

const KEPT_LINKS = { ...scanInfo("s1").links };
const drawnLine = (name: string, x: number) => ({ ...lineAlong(name, "#101010", [[x, 0, 0], [x + 10, 0, 0]], false), id: `${name.replace(" ", "-")}-of-${x}` });

/** Both stances of one patient in two tabs: s1 in work, s2 beside it. */
async function twoTabs() {
  const plans = fakePlans();
  const open = async () => {
    const made = page(plans);
    const other = { ...workspaceOf(made.store.get()), scan: { info: { ...scanInfo("s2"), links: { ...scanInfo("s2").links, plan: KEPT_LINKS.plan } } } } as unknown as Workspace;
    await made.actions.scan.open("s1", null);
    made.store.set((state) => ({ stances: { ...state.stances, other } }));
    const draw = (name: string, x: number) => made.actions.drawing.restore([...made.store.get().drawn.lines.present, drawnLine(name, x)]);
    const shown = () => {
      const { drawn, drawing, stances } = made.store.get();
      return { lines: drawn.lines.present.map(({ name }) => name), drawing, note: drawn.note, saving: drawn.saving, beside: stances.other!.drawn.lines.present.map(({ name }) => name) };
    };
    return { ...made, draw, shown };
  };
  return { mine: await open(), theirs: await open(), kept: async () => (await plans.plan(KEPT_LINKS.plan)).items };
}

test("two tabs: what one writes over the other's change it shows from then on, so that its next change deletes none of it", async () => {
  const { mine, theirs, kept } = await twoTabs();
  theirs.draw("theirs", 0);
  theirs.actions.drawing.choosePattern("reduction:areola_mm=42");
  theirs.actions.plan.note("smaller");
  await vi.advanceTimersByTimeAsync(1000);
  await theirs.client.savePlan(KEPT_LINKS.plan, [...(await kept()), line("c", "beside", "s2")], (await theirs.client.plan(KEPT_LINKS.plan)).seen ?? null);
  mine.actions.plan.depth(12); // of no tumour: nothing changes, and nothing is asked
  mine.actions.drawing.choosePattern("lumpectomy+tumour:side=R,clock=3,distance_mm=30,radius_mm=10");
  mine.actions.plan.depth(25);
  await vi.advanceTimersByTimeAsync(1000);
  expect(mine.shown()).toMatchObject({ lines: ["theirs"], note: "smaller", saving: "saved", beside: ["beside"] });
  expect(mine.store.get().problems.drawing).toMatch(/changed in another tab/);
  mine.draw("mine", 50);
  mine.draw("mine too", 90);
  await vi.advanceTimersByTimeAsync(1000);
  expect(mine.shown()).toMatchObject({ lines: ["theirs", "mine", "mine too"], saving: "saved" });
  expect(linesOn(await kept(), "s1").map(({ name }) => name)).toEqual(["theirs", "mine", "mine too"]);
  expect(linesOn(await kept(), "s2").map(({ name }) => name)).toEqual(["beside"]);
});

test("two tabs: lines drawn while the first one is on its way stay, with those of the other tab; a pattern that was changed there is shown here", async () => {
  const { mine, theirs, kept } = await twoTabs();
  theirs.draw("theirs", 0);
  theirs.actions.drawing.choosePattern("reduction:areola_mm=42");
  await vi.advanceTimersByTimeAsync(1000);
  let answer: () => void = () => undefined;
  mine.client.plan = vi.fn(async (link: string) => {
    await new Promise<void>((come) => (answer = come));
    return theirs.client.plan(link);
  });
  mine.draw("mine", 50);
  await vi.advanceTimersByTimeAsync(1000);
  mine.draw("meanwhile", 90);
  await vi.advanceTimersByTimeAsync(1000);
  answer();
  await vi.advanceTimersByTimeAsync(1000);
  expect(mine.shown()).toMatchObject({ lines: ["theirs", "mine", "meanwhile"], drawing: "reduction:areola_mm=42", saving: "saved" });
  expect(linesOn(await kept(), "s1").map(({ name }) => name)).toEqual(["theirs", "mine", "meanwhile"]);
  const { version } = await theirs.client.plan(KEPT_LINKS.plan);
  theirs.draw("again", 130);
  await vi.advanceTimersByTimeAsync(1000);
  expect((await theirs.client.plan(KEPT_LINKS.plan)).version, "what was taken over is not written back").toBe(version + 1);
  expect(theirs.shown().lines).toEqual(["theirs", "mine", "meanwhile", "again"]);
});

test("changes are written one after the other, a failed one stops no later one, and nothing is written for nothing", async () => {
  const client = fakePlans();
  const keeper = createPlanKeeper(client);
  client.savePlan.mockImplementationOnce(async () => {
    throw new ApiError("no disk", 507);
  });
  const failed = keeper.save("p", (items) => [...items, note("a", "lost")]);
  const first = keeper.save("p", (items) => [...items, note("b", "b")]);
  const second = keeper.save("p", (items) => [...items, note("c", "c")]);
  await expect(failed).rejects.toThrow("no disk");
  await Promise.all([first, second]);
  expect(client.savePlan.mock.calls.slice(1).map(([, items]) => ids(items))).toEqual([["b"], ["b", "c"]]);
  expect(ids(keeper.seen("p")!.items)).toEqual(["b", "c"]);
  const calls = client.savePlan.mock.calls.length;
  await keeper.save("p", (items) => [...items]);
  expect(client.savePlan).toHaveBeenCalledTimes(calls);
});

beforeEach(() => void vi.useFakeTimers());
afterEach(() => void vi.useRealTimers());

test("a reload brings back pattern and tumour, and how the fit was asked for: a nudge changes nothing else", async () => {
  const startFit = vi.fn(async () => ({ id: "f2", links: fitLinks("f2") }));
  const fit = { id: "f1", links: fitLinks("f1"), drawing: TEXT, state: "done", asked_stance: "supine", preset: "paper", refine: false, landmarks: {}, certain: [] } as unknown as Fit;
  const savePlan = vi.fn();
  const made = page({ startFit, savePlan, plan: async () => ({ schema: "breastrig/plan@1", unit: "mm", version: 4, whole: true, scans: [], items: ITEMS }), fit: async () => fit });
  await made.actions.scan.open("s1", null);
  await made.actions.fit.open("f1");
  expect(made.store.get()).toMatchObject({ drawing: TEXT, stance: "supine", preset: "paper", refine: false });
  await made.actions.fit.start();
  expect(startFit).toHaveBeenCalledWith(expect.objectContaining({ stance: "supine", preset: "paper", refine: false }));
  expect(startFit).not.toHaveBeenCalledWith(expect.objectContaining({ drawing: expect.anything() as string }));
  expect(savePlan).not.toHaveBeenCalled();
});

test("a fit plans nothing by itself; a pattern that is chosen is written at once", async () => {
  const made = page();
  await made.actions.scan.open("s1", null);
  const plan = async () => (await made.client.plan("/api/patients/of-s1/plan")).items.map((item) => (item.kind === "pattern" ? [item.scan, item.name] : item.kind));
  await made.actions.fit.start();
  await vi.advanceTimersByTimeAsync(10);
  expect([await plan(), made.store.get().drawing]).toEqual([[], ""]);
  made.actions.drawing.choosePattern("reduction+tumour:side=R,clock=3,distance_mm=30,radius_mm=10");
  await vi.advanceTimersByTimeAsync(10);
  expect(await plan()).toEqual([["s1", "reduction"], "tumour"]);
  void made.actions.scan.leave();
  await vi.advanceTimersByTimeAsync(10);
  expect(await plan()).toEqual([["s1", "reduction"], "tumour"]);
});

test("what is said about the plan is kept with it, and there again", async () => {
  const made = page();
  await made.actions.scan.open("s1", null);
  made.actions.drawing.choosePattern("lumpectomy+tumour:side=R,clock=3,distance_mm=30,radius_mm=10");
  made.actions.plan.depth(25);
  made.actions.plan.note("wants it smaller");
  await vi.advanceTimersByTimeAsync(10);
  await made.actions.scan.leave();
  expect(made.store.get().drawn).toMatchObject({ note: "", depthMm: null });
  await made.actions.scan.open("s1", null);
  expect(made.store.get().drawn).toMatchObject({ note: "wants it smaller", depthMm: 25 });
});

test("undoing goes back beyond the opening of the page: lines, patterns, tumours and notes, step by step", async () => {
  const made = page();
  const link = scanInfo("s1").links.plan;
  const pattern = (mm: number): PlanItem => ({ kind: "pattern", id: "p", scan: "s1", name: "reduction", parameters: { areola_mm: mm } });
  const tumour = (depth: number | null): PlanItem => ({ kind: "tumour", id: "t", scan: "s1", side: "L", clock: 10, distance_mm: 45, radius_mm: 12, depth_mm: depth });
  const versions: PlanItem[][] = [[line("a", "Line 1")]];
  for (const item of [pattern(42), tumour(null), note("n", "smaller"), line("b", "Line 2")]) versions.push([...versions.at(-1)!, item]);
  versions.push(versions.at(-1)!.map((item) => (item.id === "p" ? pattern(40) : item)));
  versions.push([...versions.at(-1)!, line("x", "Line 1", "s2")]); // on the other scan: no step here
  for (const [number, items] of versions.entries()) await made.client.savePlan(link, items, number === 0 ? "0" : `of ${number}`);
  await made.actions.scan.open("s1", null);
  const shown = () => {
    const { drawing, drawn } = made.store.get();
    return [drawn.lines.present.map(({ name }) => name).join(), drawing, drawn.note];
  };
  const circle = "tumour:side=L,clock=10,distance_mm=45,radius_mm=12";
  const steps = [
    ["Line 1,Line 2", `reduction:areola_mm=40+${circle}`, "smaller"],
    ["Line 1,Line 2", `reduction:areola_mm=42+${circle}`, "smaller"],
    ["Line 1", `reduction:areola_mm=42+${circle}`, "smaller"],
    ["Line 1", `reduction:areola_mm=42+${circle}`, ""],
    ["Line 1", "reduction:areola_mm=42", ""],
    ["Line 1", "", ""],
  ];
  expect(shown()).toEqual(steps[0]);
  for (const step of steps.slice(1)) {
    made.actions.drawing.undo();
    await vi.advanceTimersByTimeAsync(1000);
    expect(shown()).toEqual(step);
  }
  expect(ids((await made.client.plan(link)).items)).toEqual(["x", "a"]);
  for (const step of steps.slice(0, -1).reverse()) {
    made.actions.drawing.redo();
    await vi.advanceTimersByTimeAsync(1000);
    expect(shown()).toEqual(step);
  }
  expect((await made.client.plan(link)).items.map(({ kind }) => kind).sort()).toEqual(["line", "line", "line", "note", "pattern", "tumour"]);
});

test("a pattern, a depth and a note that were changed here are one step each, back and forth", async () => {
  const made = page();
  await made.actions.scan.open("s1", null);
  made.actions.drawing.choosePattern("reduction+tumour:side=R,clock=3,distance_mm=30,radius_mm=10");
  made.actions.plan.depth(25);
  made.actions.plan.note("wants it smaller");
  await vi.advanceTimersByTimeAsync(10);
  const drawn = () => made.store.get().drawn;
  made.actions.drawing.undo();
  expect(drawn()).toMatchObject({ note: "", depthMm: 25 });
  made.actions.drawing.undo();
  expect(drawn()).toMatchObject({ note: "", depthMm: null });
  made.actions.drawing.undo();
  expect(made.store.get().drawing).toBe("");
  for (let count = 0; count < 3; count += 1) made.actions.drawing.redo();
  expect(drawn()).toMatchObject({ note: "wants it smaller", depthMm: 25 });
  await vi.advanceTimersByTimeAsync(1000);
  const kept = (await made.client.plan(scanInfo("s1").links.plan)).items;
  expect(kept.find(({ kind }) => kind === "tumour")).toMatchObject({ depth_mm: 25, clock: 3 });
  expect(noteOn(kept, "s1")).toBe("wants it smaller");
});

test("a tab that is looked at again learns that the plan was written elsewhere, and takes it over in one step", async () => {
  const made = page();
  const link = scanInfo("s1").links.plan;
  await made.client.savePlan(link, [line("a", "Line 1")], "0");
  await made.actions.scan.open("s1", null);
  const drawn = () => made.store.get().drawn;
  await made.actions.plan.look();
  expect(drawn().isChangedElsewhere).toBe(false);
  await made.client.savePlan(link, [line("a", "Line 1"), line("b", "Line 2"), note("n", "theirs"), ITEMS[1]!], "of 1");
  await made.actions.plan.look();
  expect(drawn().isChangedElsewhere).toBe(true);
  expect(linesOn((await made.client.plan(link)).items, "s1"), "nothing is written by looking").toHaveLength(2);
  await made.actions.plan.takeOver();
  expect(drawn()).toMatchObject({ isChangedElsewhere: false, note: "theirs" });
  expect(drawn().lines.present.map(({ name }) => name)).toEqual(["Line 1", "Line 2"]);
  expect(made.store.get().drawing).toBe("reduction:side=L,areola_mm=40");
  await made.actions.plan.look();
  expect(drawn().isChangedElsewhere).toBe(false);
  made.actions.drawing.undo();
  expect(drawn().lines.present.map(({ name }) => name)).toEqual(["Line 1"]);
});

test("the stance that waits takes over what was planned on it elsewhere", async () => {
  const made = page();
  const link = scanInfo("s1").links.plan;
  const other = { ...workspaceOf(made.store.get()), scan: { info: { ...scanInfo("s2"), links: { ...scanInfo("s2").links, plan: link } } } } as unknown as Workspace;
  await made.actions.scan.open("s1", null);
  made.store.set((state) => ({ stances: { ...state.stances, other } }));
  await made.client.savePlan(link, [line("a", "Line 1"), line("b", "Line 2", "s2")], "0");
  await made.actions.plan.takeOver();
  await vi.advanceTimersByTimeAsync(10);
  expect(made.store.get().stances.other!.drawn.lines.present.map(({ name }) => name)).toEqual(["Line 2"]);
});

test("how deep a line is cut stays in the plan, until it is not said any more", () => {
  const line = { ...lineAlong("Cut", "#101010", [[0, 0, 0], [9, 0, 0], [9, 9, 0]], true), id: "m", depthMm: 25 };
  const items = withLines([], "scan", [line]);
  expect(items[0]).toMatchObject({ kind: "line", depth_mm: 25 });
  expect(linesOn(items, "scan")[0]!.depthMm).toBe(25);
  const { depthMm: _, ...unsaid } = line;
  expect(withLines(items, "scan", [unsaid])[0]).not.toHaveProperty("depth_mm");
});

test("a mirrored line stays one in the plan, and half a tumour is none", () => {
  const line = { ...lineAlong("Line 1, mirrored", "#101010", [[0, 0, 0], [9, 0, 0]], false), id: "m", mirrored: true };
  const items = withLines([], "scan", [line]);
  expect(items[0]).toMatchObject({ kind: "line", mirrored: true });
  expect(linesOn(items, "scan")[0]!.mirrored).toBe(true);
  expect(linesOn(withLines([], "scan", [{ ...line, mirrored: undefined }]), "scan")[0]!.mirrored).toBeUndefined();
  expect(withDrawing([], "scan", "tumour:clock=12,distance_mm=40,radius_mm=15")).toEqual([]);
  expect(withDrawing([], "scan", "tumour:side=L,distance_mm=40,radius_mm=15")).toEqual([]);
});

/** A service whose scan s1 somebody may give another size. */
function sizedPlans() {
  let scale = 1;
  const kept = fakePlans();
  const now = (plan: StoredPlan): StoredPlan => ({ ...plan, seen: `${plan.seen} at ${scale}`, scans: [{ id: "s1", ...(scale === 1 ? {} : { scale }) }], items: timesLarger(plan.items, () => scale) });
  return {
    resize: (to: number): void => void (scale = to),
    places: async () => (await kept.plan(scanInfo("s1").links.plan)).items.flatMap((item) => (item.kind === "line" ? item.points.map(([x]) => Math.round(scale * x * 1e6) / 1e6) : [])),
    scan: async (id: string) => ({ ...scanInfo(id), ...(scale === 1 ? {} : { scale: { factor: scale } }) }) as Scan,
    plan: async (link: string) => now(await kept.plan(link)),
    savePlan: vi.fn(async (link: string, items: readonly PlanItem[], seen: string | null, sizes: ReadonlyMap<string, number> = new Map()) => {
      const [tag, at] = (seen ?? "").split(" at ");
      if (tag !== "0" && Number(at) !== scale) throw new ApiError("Somebody has changed this plan.", 412);
      return now(await kept.savePlan(link, timesLarger(items, () => 1 / (sizes.get("s1") ?? scale)), tag!));
    }),
  };
}

test("what is planned in a page that shows the size before is kept in that size, and so is what could not be saved", async () => {
  const kept = sizedPlans();
  const pen = (name: string, x: number): OwnLine => lineAlong(name, "#101010", [[x, 0, 0], [x + 10, 0, 0]], false);
  const draw = async ({ actions }: ReturnType<typeof page>, name: string, x: number): Promise<void> => {
    actions.drawing.adopt([pen(name, x)], {}, "");
    await actions.drawing.flush();
    await actions.plan.settled();
  };
  const one = page(kept);
  await one.actions.scan.open("s1", null);
  kept.resize(1.25);
  await draw(one, "first", 10);
  expect(await kept.places(), "though there was no plan, whose tag is the same in each size").toEqual([12.5, 25]);
  kept.resize(0.8);
  await draw(one, "second", 100);
  expect(await kept.places()).toEqual([8, 16, 80, 88]);
  expect(one.store.get().drawn.lines.present.map(({ name, points }) => [name, points.map(([x]) => x)]), "none twice").toEqual([["first", [10, 20]], ["second", [100, 110]]]);
  kept.savePlan.mockRejectedValueOnce(new ApiError("Nobody answers.", 0));
  await draw(one, "third", 200);
  kept.resize(1.25);
  const again = page(kept, one.tab);
  await again.actions.scan.open("s1", null);
  await vi.waitFor(() => expect(again.store.get().drawn.saving).toBe("saved"));
  expect(await kept.places()).toEqual([12.5, 25, 125, 137.5, 250, 262.5]);
});
