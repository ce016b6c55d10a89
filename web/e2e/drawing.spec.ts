// The surgeon's own drawing: strokes and clicks on the canvas become lines on the skin, kept by the service, undone and redone,
// edited point by point, and read back after a reload.
import { readFileSync, writeFileSync } from "node:fs";
import { expect, type Page } from "@playwright/test";
import type { OwnDrawing, PlanOnScan, Vector } from "../src/api/types";
import { mmFrom } from "../src/ui/units";
import { cross } from "../src/viewer/frame";
import { addToPlan, details, distance, fittedExample, hook, look, numberField, openDetails, openFiles, planItem, SCAN_FILE, test, trueLandmarks, untilFitted, untilStill } from "./page";

const ON_SKIN_MM = 0.5;

/** Distance of places (mm) to the scan's surface, by the mesh that the service keeps: brute force, nothing of the page's. */
async function toSurface(page: Page, base: string, points: readonly Vector[]): Promise<number> {
  const links = await page.evaluate(() => window.__breastrig!.state().scan!.info.links);
  const glb = await (await page.request.get(base + links.mesh)).body();
  const { positions, index } = readGlb(glb);
  return Math.max(...points.map((point) => nearest(point.map((mm) => mm / 1000) as Vector, positions, index) * 1000));
}

interface Accessor {
  bufferView: number;
  byteOffset?: number;
  componentType: number;
  count: number;
}

interface Gltf {
  meshes: { primitives: { attributes: { POSITION: number }; indices: number }[] }[];
  accessors: Accessor[];
  bufferViews: { byteOffset?: number }[];
}

function readGlb(glb: Buffer): { positions: Float32Array; index: Uint32Array | Uint16Array } {
  const jsonLength = glb.readUInt32LE(12);
  const json = JSON.parse(glb.subarray(20, 20 + jsonLength).toString("utf8")) as Gltf;
  const start = 20 + jsonLength + 8;
  const bytes = (accessor: Accessor): number => start + (json.bufferViews[accessor.bufferView]!.byteOffset ?? 0) + (accessor.byteOffset ?? 0);
  const { attributes, indices } = json.meshes[0]!.primitives[0]!;
  const [p, i] = [json.accessors[attributes.POSITION]!, json.accessors[indices]!];
  const copy = (at: number, length: number): ArrayBuffer => glb.buffer.slice(glb.byteOffset + at, glb.byteOffset + at + length) as ArrayBuffer;
  const positions = new Float32Array(copy(bytes(p), 12 * p.count));
  const index = i.componentType === 5125 ? new Uint32Array(copy(bytes(i), 4 * i.count)) : new Uint16Array(copy(bytes(i), 2 * i.count));
  return { positions, index };
}

function nearest(p: Vector, at: Float32Array, index: ArrayLike<number>): number {
  let best = Infinity;
  for (let k = 0; k < index.length; k += 3) {
    const [a, b, c] = [3 * index[k]!, 3 * index[k + 1]!, 3 * index[k + 2]!];
    const near = Math.abs(at[a]! - p[0]) < best + 0.02 && Math.abs(at[a + 1]! - p[1]) < best + 0.02 && Math.abs(at[a + 2]! - p[2]) < best + 0.02;
    if (near) best = Math.min(best, toTriangle(p, at.subarray(a, a + 3), at.subarray(b, b + 3), at.subarray(c, c + 3)));
  }
  return best;
}

type Triple = ArrayLike<number>;
const less = (a: Triple, b: Triple): Vector => [a[0]! - b[0]!, a[1]! - b[1]!, a[2]! - b[2]!];
const dot = (a: Triple, b: Triple): number => a[0]! * b[0]! + a[1]! * b[1]! + a[2]! * b[2]!;

function toSegment(p: Triple, a: Triple, b: Triple): number {
  const along = less(b, a);
  const share = Math.min(1, Math.max(0, dot(less(p, a), along) / Math.max(dot(along, along), 1e-18)));
  return Math.hypot(...less(p, [a[0]! + share * along[0], a[1]! + share * along[1], a[2]! + share * along[2]]));
}

function toTriangle(p: Triple, a: Triple, b: Triple, c: Triple): number {
  const [u, v] = [less(b, a), less(c, a)];
  const n: Vector = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
  const square = dot(n, n);
  if (square > 0) {
    const w = less(p, a);
    const cross = (x: Vector, y: Vector): Vector => [x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]];
    const [s, t] = [dot(cross(w, v), n) / square, dot(cross(u, w), n) / square];
    if (s >= 0 && t >= 0 && s + t <= 1) return Math.abs(dot(w, n)) / Math.sqrt(square);
  }
  return Math.min(toSegment(p, a, b), toSegment(p, b, c), toSegment(p, c, a));
}

const lines = (page: Page) => page.evaluate(() => window.__breastrig!.state().drawn.lines.present);
const drawn = (page: Page) => page.evaluate(() => window.__breastrig!.state().drawn);

async function at(page: Page, point: Vector): Promise<{ x: number; y: number }> {
  return hook.project(page, point);
}

async function open(page: Page, base: string): Promise<void> {
  await page.goto(base);
  await page.locator("#scan-file").setInputFiles(SCAN_FILE);
  await hook.ready(page);
  await untilStill(page);
  await page.keyboard.press("3");
}

async function kept(page: Page, base: string): Promise<OwnDrawing> {
  await expect(page.locator(".top-bar .saved")).toHaveText("Saved");
  const links = await page.evaluate(() => window.__breastrig!.state().scan!.info.links);
  return (await (await page.request.get(base + links.drawing)).json()) as OwnDrawing;
}

test("strokes and clicks become lines on the skin; they are kept, undone, named, and there again after a reload", async ({ page, base, troubles }, info) => {
  const truth = trueLandmarks();
  await open(page, base);
  const empty = await hook.picture(page);

  await test.step("the pen draws where the hand goes", async () => {
    await page.getByRole("button", { name: "Pen", exact: true }).click();
    const from = await at(page, truth.nipple_R!);
    await page.mouse.move(from.x - 30, from.y - 60);
    await page.mouse.down();
    for (let i = 1; i <= 24; i += 1) await page.mouse.move(from.x - 30 + 3 * i, from.y - 60 + 20 * Math.sin(i / 6));
    await page.mouse.up();
    const [line] = await lines(page);
    expect(line!.name).toBe("Line 1");
    expect(line!.points.length).toBeGreaterThan(20);
    const hit = await page.evaluate(([x, y]) => window.__breastrig!.pickAt(x!, y!)!.point, [from.x + 6, from.y - 60 + 20 * Math.sin(2)]);
    expect(Math.min(...line!.points.map((point) => distance(point, hit)))).toBeLessThan(2);
    expect(await toSurface(page, base, line!.points)).toBeLessThan(ON_SKIN_MM);
    expect((await hook.picture(page)).checksum).not.toBe(empty.checksum);
  });

  await test.step("the second button turns the body and draws nothing", async () => {
    const before = await hook.picture(page);
    const box = (await page.locator("main canvas.view").boundingBox())!;
    await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
    await page.mouse.down({ button: "right" });
    await page.mouse.move(box.x + box.width / 2 + 60, box.y + box.height / 2, { steps: 4 });
    await page.mouse.up({ button: "right" });
    expect((await hook.picture(page)).checksum).not.toBe(before.checksum);
    expect(await lines(page)).toHaveLength(1);
    await page.keyboard.press("f");
    await untilStill(page);
  });

  await test.step("clicks set corners joined along the skin; a click on the first closes the ring", async () => {
    const middle = await at(page, truth.nipple_L!);
    for (const [dx, dy] of [[-45, -40], [8, -40], [8, 12], [-45, 12], [-45, -40]] as const) await page.mouse.click(middle.x + dx, middle.y + dy);
    const ring = (await lines(page))[1]!;
    expect(ring.closed).toBe(true);
    expect(ring.corners).toHaveLength(4);
    const corner = await page.evaluate(([x, y]) => window.__breastrig!.pickAt(x!, y!)!.point, [middle.x + 8, middle.y + 12]);
    expect(distance(ring.points[ring.corners[2]!]!, corner)).toBeLessThan(0.5);
    expect(await toSurface(page, base, ring.points)).toBeLessThan(ON_SKIN_MM);
    const steps = ring.points.map((point, i) => distance(point, ring.points[(i + 1) % ring.points.length]!));
    expect(Math.max(...steps)).toBeLessThan(4);
  });

  await test.step("a tumour is a circle of its radius around the click", async () => {
    await page.getByRole("button", { name: "Tumour", exact: true }).click();
    await page.locator("[data-parameter=next_radius_mm]").fill("20");
    await page.locator("[data-parameter=next_radius_mm]").press("Tab");
    const place = await at(page, truth.nipple_L!);
    await page.mouse.click(place.x, place.y - 15);
    const circle = (await lines(page))[2]!;
    const centre = await page.evaluate(([x, y]) => window.__breastrig!.pickAt(x!, y!)!.point, [place.x, place.y - 15]);
    expect(circle.name).toBe("Tumour 20 mm");
    for (const point of circle.points) expect(distance(point, centre)).toBeLessThan(20.1);
    expect(Math.max(...circle.points.map((point) => distance(point, centre)))).toBeGreaterThan(17);
    expect(await toSurface(page, base, circle.points)).toBeLessThan(ON_SKIN_MM);
  });

  await test.step("undo and redo by key and button; the service keeps what is shown", async () => {
    await page.keyboard.press("Escape");
    await page.keyboard.press("z");
    expect(await lines(page)).toHaveLength(2);
    await page.getByRole("button", { name: "Redo (Shift+Z)" }).last().click();
    expect(await lines(page)).toHaveLength(3);
    const file = await kept(page, base);
    const shown = await lines(page);
    expect(file.shapes.map(({ name, closed, points }) => ({ name, closed, count: points.length }))).toEqual(
      shown.map(({ name, closed, points }) => ({ name, closed, count: points.length })),
    );
    expect(distance(file.shapes[1]!.points[5]!, shown[1]!.points[5]!)).toBeLessThan(0.01);
  });

  await test.step("a point is dragged, nudged, added and deleted; the line stays on the skin", async () => {
    await page.keyboard.press("e");
    await planItem(page, "Line 2").click();
    const before = (await lines(page))[1]!;
    const spot = await at(page, before.points[before.corners[1]!]!);
    await page.mouse.move(spot.x, spot.y);
    await page.mouse.down();
    await page.mouse.move(spot.x - 14, spot.y - 16, { steps: 5 });
    await page.mouse.up();
    let ring = (await lines(page))[1]!;
    expect(distance(ring.points[ring.corners[1]!]!, before.points[before.corners[1]!]!)).toBeGreaterThan(5);
    expect(ring.points[ring.corners[3]!]).toEqual(before.points[before.corners[3]!]);
    expect(await toSurface(page, base, ring.points)).toBeLessThan(ON_SKIN_MM);
    await page.locator("main canvas.view").focus();
    const moved = ring.points[ring.corners[1]!]!;
    await page.keyboard.press("Shift+ArrowRight");
    ring = (await lines(page))[1]!;
    expect(distance(ring.points[ring.corners[1]!]!, moved)).toBeGreaterThan(1);
    await page.keyboard.press("Delete");
    expect((await lines(page))[1]!.corners).toHaveLength(3);
    const side = await at(page, (await lines(page))[1]!.points[Math.round(((await lines(page))[1]!.corners[1]! + (await lines(page))[1]!.corners[2]!) / 2)]!);
    await page.mouse.click(side.x, side.y);
    expect((await lines(page))[1]!.corners).toHaveLength(4);
  });

  await test.step("by buttons alone: next point, move, delete, close, rename, switch off, erase", async () => {
    await page.getByRole("button", { name: "Next point" }).click();
    await expect(page.getByText(/^Point \d of 4$/)).toBeVisible();
    const before = await lines(page);
    await page.getByRole("button", { name: "Up", exact: true }).click();
    expect((await lines(page))[1]).not.toEqual(before[1]);
    await page.getByRole("button", { name: "Delete point" }).click();
    expect((await lines(page))[1]!.corners).toHaveLength(3);
    await planItem(page, "Line 1").click();
    await page.getByRole("button", { name: "Close Line 1 to a ring" }).click();
    expect((await lines(page))[0]!.closed).toBe(true);
    await page.getByLabel("Name of Line 1").fill("incision");
    await page.getByLabel("Name of Line 1").press("Enter");
    expect((await lines(page))[0]!.name).toBe("incision");
    await page.keyboard.press("Escape");
    await untilStill(page);
    const full = await hook.picture(page);
    await page.getByLabel("Show incision").uncheck();
    expect((await hook.picture(page)).checksum).not.toBe(full.checksum);
    await page.getByLabel("Show incision").check();
    expect((await hook.picture(page)).checksum).toBe(full.checksum);
    await planItem(page, "Line 2").click();
    await page.getByRole("button", { name: "Erase Line 2" }).click();
    expect((await lines(page)).map(({ name }) => name)).toEqual(["incision", "Tumour 20 mm"]);
  });

  await test.step("out to a file and in again", async () => {
    const waiting = page.waitForEvent("download");
    await openFiles(page);
    await page.getByRole("button", { name: "lines.json" }).click();
    const path = info.outputPath("drawing.json");
    await (await waiting).saveAs(path);
    const file = JSON.parse(readFileSync(path, "utf8")) as OwnDrawing;
    await page.keyboard.press("3");
    expect(file).toMatchObject({ schema: "breastrig/drawing@1", unit: "mm" });
    const other = info.outputPath("other.json");
    writeFileSync(other, JSON.stringify({ ...file, shapes: file.shapes.slice(0, 1) }));
    await page.locator("#drawing-file").setInputFiles(other);
    await expect.poll(async () => (await lines(page)).map(({ name }) => name)).toEqual(["incision", "Tumour 20 mm", "incision 2"]);
    writeFileSync(other, "{");
    await page.locator("#drawing-file").setInputFiles(other);
    await expect(page.locator(".drawing [role=alert]").first()).toContainText("not valid JSON");
    await page.keyboard.press("z");
    await expect(page.locator(".top-bar .saved")).toHaveText("Saved");
  });

  await test.step("after a reload the lines are there", async () => {
    const before = await lines(page);
    await page.reload();
    await hook.ready(page);
    await page.keyboard.press("3");
    await expect.poll(async () => (await lines(page)).map(({ name }) => name)).toEqual(before.map(({ name }) => name));
    for (const [i, line] of (await lines(page)).entries()) {
      expect(line.points).toHaveLength(before[i]!.points.length);
      expect(distance(line.points[3]!, before[i]!.points[3]!)).toBeLessThan(0.01);
    }
    expect((await drawn(page)).saving).toBe("saved");
  });

  expect((await hook.picture(page)).isLost).toBe(false);
  expect(troubles).toEqual([]);
});

test("the pen by keys alone: a cross on the body, Enter sets corners, twice ends the line", async ({ page, base, troubles }) => {
  await open(page, base);
  await page.keyboard.press("p");
  await page.locator("main canvas.view").first().focus();
  await page.keyboard.press("ArrowUp");
  await expect(page.locator(".crosshair")).toBeVisible();
  await page.keyboard.press("Enter");
  for (let i = 0; i < 4; i += 1) await page.keyboard.press("Shift+ArrowUp");
  await page.keyboard.press("Enter");
  expect((await lines(page))[0]!.corners).toHaveLength(2);
  for (let i = 0; i < 2; i += 1) await page.keyboard.press("Shift+ArrowRight");
  await page.keyboard.press("Enter");
  expect((await lines(page))[0]!.corners).toHaveLength(3);
  await page.keyboard.press("Enter");
  expect((await drawn(page)).open).toBeNull();
  expect(await toSurface(page, base, (await lines(page))[0]!.points)).toBeLessThan(ON_SKIN_MM);
  await page.keyboard.press("Escape");
  await expect(page.locator(".crosshair")).toBeHidden();
  expect(troubles).toEqual([]);
});

test("a pattern with its numbers and a tumour by the clock are drawn on the fitted patient", async ({ page, base, troubles }) => {
  await fittedExample(page, base);
  const first = (await hook.fit(page))!.id;
  await untilStill(page);
  const before = await hook.picture(page);
  await addToPlan(page, /Wise/);
  await expect(page.locator(`.item-details [data-line="wise_L"]`)).toHaveCount(1); // it is drawn
  const areola = numberField(page, "areola_mm");
  await areola.fill("99");
  await areola.press("Tab");
  await expect(details(page).getByText("New areola, left must lie between 30 and 55 mm.")).toBeVisible();
  await areola.fill("44,5");
  await areola.press("Tab");
  await details(page).getByText("side, angles, position, new fold").click();
  await numberField(page, "opening_deg", "R").fill("95.5");
  await numberField(page, "opening_deg", "R").press("Tab");
  await addToPlan(page, /^Tumour by the clock/);
  await details(page).locator("[data-parameter=side]").last().selectOption("L");
  for (const [name, value] of Object.entries({ clock: "10", distance_mm: "40", radius_mm: "15" })) {
    await numberField(page, name).fill(value);
    await numberField(page, name).press("Tab");
  }
  const wanted = "reduction:areola_mm=44.5,opening_deg=95.5+tumour:side=L,clock=10,distance_mm=40,radius_mm=15";
  expect((await hook.state(page)).drawing).toBe(wanted);
  const names = ["wise_L", "wise_R", "areola_L", "tumour_L"];
  expect((await hook.fit(page))!.id, "the fit stays").toBe(first);
  const file = (await (await page.request.get(`${base}/api/fits/${first}/plan.json`)).json()) as { shapes: { name: string; points: Vector[] }[] };
  expect(file.shapes.map(({ name }) => name)).toEqual(expect.arrayContaining(names));
  await expect(page.locator(".plan-item")).toContainText(["Reduction (Wise pattern)", "Tumour, left breast"]);
  await untilStill(page);
  expect((await hook.picture(page)).checksum).not.toBe(before.checksum);

  await addToPlan(page, /^Lesion in an image/);
  const lesions = page.locator(".item-details");
  await lesions.getByLabel("Centre").fill("1, 2");
  await lesions.getByRole("button", { name: "Add" }).click();
  await expect(lesions.getByText(/needs three numbers/)).toBeVisible();
  const { nipple_L: nipple, acromion_L: shoulder } = trueLandmarks();
  const center = nipple!.map((value, i) => Math.round(0.8 * value + 0.2 * shoulder![i]!)) as Vector;
  await lesions.getByLabel("Name").fill("MRI 1");
  await lesions.getByLabel("Centre").fill(center.join(" "));
  const without = await hook.picture(page);
  await lesions.getByRole("button", { name: "Add" }).click();
  await expect(planItem(page, "MRI 1")).toContainText(/\d+\smm deep/);
  await expect(page.locator(".lesion-view")).toContainText(/To the nipple\d+\smm, \d+ to \d+To the chest wall\d+\smm, \d+ to \d+To Wise/);
  await untilStill(page);
  expect((await hook.picture(page)).checksum, "the ball is seen through the skin").not.toBe(without.checksum);
  const laid = (await (await page.request.get(`${base}/api/fits/${first}/plan.json`)).json()) as PlanOnScan;
  expect(laid.lesions).toMatchObject([{ name: "MRI 1", radius_mm: 5, error_mm: 0, carried: false }]);

  const { slices: [axial] } = laid.lesions[0]!;
  await expect(lesions.getByRole("img", { name: /\d+\smm (below|outside) the skin \(90\s%: \d+–\d+\smm\)/ })).toBeVisible();
  const slice = page.getByRole("img", { name: /^Axial slice/ });
  await slice.press("ArrowRight"); // the cross alone
  await lesions.getByRole("button", { name: "Move MRI 1" }).click();
  await expect(page.getByText("Dragging and arrow keys move MRI 1; its handle")).toBeVisible();
  for (let k = 0; k < 3; k += 1) await slice.press("ArrowRight");
  const moved = center.map((value, i) => value + 3 * axial!.right[i]!);
  const now = async () => ((await (await page.request.get(`${base}/api/fits/${first}/plan.json`)).json()) as PlanOnScan).lesions[0]!.center.map((value) => mmFrom(value, laid.unit));
  await expect.poll(async () => distance((await now()) as Vector, moved as Vector)).toBeLessThan(0.3);
  await slice.press("Escape");

  // A fit again is not asked to draw the plan, however long that is; where it fails, the page says so where she looks.
  await page.evaluate(() => (document.activeElement as HTMLElement).blur()); // else the key is written into a field
  await page.keyboard.press("1");
  await openDetails(page);
  await page.getByLabel("Follow the skin").uncheck();
  await page.getByRole("button", { name: /^Fit again/ }).first().click();
  await expect.poll(async () => (await hook.fit(page))!.id).not.toBe(first);
  await untilFitted(page);
  expect(JSON.stringify((await hook.state(page)).problems)).toBe("{}");
  const alone = (await page.evaluate(() => window.__breastrig!.state().fit!.result!));
  expect([alone.refined, alone.surface_distance_mm], "the model alone").toEqual([false, alone.model_alone!.surface_distance_mm]);
  await page.reload();
  await hook.ready(page);
  await untilFitted(page);
  expect((await hook.state(page)).drawing).toBe(wanted);
  await expect(page.locator(`.item-details [data-line="wise_L"]`)).toHaveCount(1);
  expect(troubles).toEqual([]);
});

test("a table is hidden and, when it is shown, the pen draws nothing on it, and a stroke that runs off the patient ends where her skin ends", async ({ page, base, troubles }) => {
  await page.goto(base);
  await page.locator("#scan-file").setInputFiles(SCAN_FILE.replace("standing", "supine"));
  await hook.ready(page);
  await untilStill(page);
  await expect(page.locator("#loose")).toHaveAttribute("aria-pressed", "false");
  await look(page, "Table and loose pieces");
  await page.keyboard.press("3");
  await page.getByRole("button", { name: "Pen", exact: true }).click();
  const canvas = (await page.locator("main canvas.view").boundingBox())!;
  const row = canvas.y + canvas.height / 2;
  const middle = canvas.x + canvas.width / 2;
  // Beside the body, in this row, a place of the table that the service has found.
  const { table, bounds } = await page.evaluate(() => {
    const { info } = window.__breastrig!.state().scan!;
    return { table: info.table!, bounds: info.bounds_m };
  });
  const onTable = (across: number): Vector => {
    const middle = bounds.min.map((low, axis) => 500 * (low + bounds.max[axis]!)) as Vector;
    const widest = [0, 1, 2].filter((axis) => Math.abs(table.normal[axis]!) < 0.5).sort((a, b) => Math.abs(left[b]!) - Math.abs(left[a]!))[0]!;
    middle[widest]! += across * 500 * (bounds.max[widest]! - bounds.min[widest]!);
    const above = dot(middle, table.normal) - 1000 * table.height_m;
    return middle.map((value, axis) => value - above * table.normal[axis]!) as Vector;
  };
  const { up, front } = await page.evaluate(() => window.__breastrig!.state().scan!.frame);
  const left = cross(up, front);
  const outside = Math.max((await hook.project(page, onTable(0.9))).x, (await hook.project(page, onTable(-0.9))).x);
  await page.mouse.move(middle, row);
  await page.mouse.down();
  for (let x = middle; x < outside; x += 12) await page.mouse.move(x, row);
  await page.mouse.up();
  const all = await lines(page);
  expect(all.length).toBeGreaterThan(0);
  const heights = all.flatMap(({ points }) => points.map((point) => dot(point, table.normal)));
  for (const line of all) for (let i = 1; i < line.points.length; i += 1) expect(distance(line.points[i - 1]!, line.points[i]!)).toBeLessThan(6);
  expect(Math.min(...heights)).toBeGreaterThan(1000 * table.height_m + 5);
  const before = all.length;
  await page.mouse.click(outside, row);
  expect((await drawn(page)).start).toBeNull();
  expect(await lines(page)).toHaveLength(before);
  expect(await page.evaluate(([x, y]) => window.__breastrig!.pickAt(x!, y!), [outside, row]), "it is not there for a click").toBeNull();
  const shown = await hook.picture(page);
  await look(page, "Table and loose pieces");
  expect((await hook.picture(page)).checksum, "it was seen").not.toBe(shown.checksum);
  expect(await page.evaluate(([x, y]) => window.__breastrig!.pickAt(x!, y!), [middle, row])).not.toBeNull();
  expect(troubles).toEqual([]);
});
