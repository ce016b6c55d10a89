// The surgeon's whole day: two stances of one patient, each with its own landmarks and fit, side by side with linked cameras, a
// drawing carried from one to the other, the measures and the report of both; all of it again after a reload, shown to a
// colleague through a link, and in the end deleted without a trace.
import { readdirSync, readFileSync, statSync } from "node:fs";
import { join } from "node:path";
import { expect, type Page } from "@playwright/test";
import type { CarriedDrawing, MeasuresFile, PlanOnScan, Vector } from "../src/api/types";
import "./words"; // before those that ask for some
import { measuresTable, saidOf } from "../src/stances/measures/measuresTable";

import { expectForEverybody } from "./audit";
import { addToPlan, details, distance, example, hook, look, more, numberField, openShare, planItem, test, thumb, untilFitted, untilStill } from "./page";
import { Owner } from "./shared";

const { state } = hook;
const other = (page: Page) => page.evaluate(() => window.__breastrig!.other());
const pose = (page: Page) => page.evaluate(() => window.__breastrig!.pose());
const unit = ([x, y, z]: Vector): Vector => [x / Math.hypot(x, y, z), y / Math.hypot(x, y, z), z / Math.hypot(x, y, z)];
const gaze = ({ eye, target }: { eye: Vector; target: Vector }): Vector => unit([eye[0] - target[0], eye[1] - target[1], eye[2] - target[2]]);
const away = ({ eye, target }: { eye: Vector; target: Vector }): number => Math.hypot(eye[0] - target[0], eye[1] - target[1], eye[2] - target[2]);
const degrees = (a: Vector, b: Vector): number => (Math.acos(Math.min(1, a[0] * b[0] + a[1] * b[1] + a[2] * b[2])) * 180) / Math.PI;

const owner = new Owner();
test.use({ contextOptions: { reducedMotion: "no-preference" } }); // with its motion, as most people see it
test.use({ base: async ({}, use) => use(owner.base) });

/** Files of a patient in the data folder. */
function patientFiles(patient: string): string[] {
  const all = readdirSync(owner.data, { recursive: true }).map(String);
  return all.filter((name) => name.includes(patient) && statSync(join(owner.data, name)).isFile());
}

async function fitWithExample(page: Page): Promise<void> {
  await page.keyboard.press("2");
  await page.getByRole("button", { name: /example/i }).first().click();
  await page.keyboard.press("1");
  await page.getByRole("button", { name: /^Fit (again )?with \d+ landmarks$/ }).first().click();
  await untilFitted(page);
}

const PATTERN = "reduction+tumour:side=L,clock=10,distance_mm=40,radius_mm=15";

/** Every line of the plan that was made on one scan lies on the other where the service's own transfer has it. */
async function samePlaces(page: Page, base: string, from: string, to: string): Promise<PlanOnScan["shapes"]> {
  const plan = async (fit: string) => (await (await page.request.get(`${base}/api/fits/${fit}/plan.json`)).json()) as PlanOnScan;
  const [own, there] = [await plan(from), await plan(to)];
  const shapes = own.shapes.filter(({ carried }) => !carried).map(({ name, closed, color, points, bridged }) => ({ name, closed, color, points, bridged }));
  const drawing = { schema: "breastrig/drawing@1", unit: own.unit, shapes };
  const answer = (await (await page.request.post(`${base}/api/transfers`, { data: { from_fit: from, to_fit: to, drawing } })).json()) as CarriedDrawing;
  const perUnit = { m: 1000, dm: 100, cm: 10, mm: 1, in: 25.4, ft: 304.8 }[answer.unit];
  const carried = there.shapes.filter((shape) => shape.carried);
  expect(carried).toHaveLength(answer.shapes.length);
  for (const shape of answer.shapes) {
    const found = carried.find(({ name }) => name === shape.name)!;
    // Rounded to micrometres, a point may change to the next triangle of a rough scan, which faces elsewhere.
    const off = shape.points.map((point, i) => distance(point, found.points[i]!) * perUnit);
    expect(Math.max(...off), shape.name).toBeLessThan(0.1);
    expect(off.toSorted((a, b) => a - b)[Math.floor(off.length / 2)], shape.name).toBeLessThan(0.002);
  }
  const now = await state(page);
  const shown = [now, now.stances.other!].find(({ fit }) => fit?.id === to)!.drawn.onScan!;
  expect(shown.carried.shapes).toEqual(carried);
  return carried;
}

async function drag(page: Page, selector: string, dx: number): Promise<void> {
  const box = (await page.locator(selector).boundingBox())!;
  await page.mouse.move(box.x + box.width / 2, box.y + 70);
  await page.mouse.down();
  await page.mouse.move(box.x + box.width / 2 + dx, box.y + 70, { steps: 4 });
  await page.mouse.up();
}

test("both stances, draw, carry, reload, report, share, delete", async ({ page, base, troubles, browser }, info) => {
  test.slow(); // a whole day
  expect((await page.request.get(`${base}/api/patients`)).status(), "another user of this machine").toBe(401);
  await page.setContent(`<meta http-equiv="refresh" content="0; url=${owner.address}">`); // as the file that `serve` opens
  await page.waitForURL(`${base}/`);
  await example(page);
  await hook.ready(page);
  await fitWithExample(page);
  const standing = (await hook.fit(page))!.id;

  await test.step("a line is drawn on the standing scan", async () => {
    await page.keyboard.press("3");
    await page.getByRole("button", { name: "Pen", exact: true }).click();
    await untilStill(page);
    const box = (await page.locator("main canvas.view").first().boundingBox())!;
    const [x, y] = [box.x + box.width * 0.42, box.y + box.height * 0.5];
    await page.mouse.move(x, y);
    await page.mouse.down();
    for (let i = 1; i <= 20; i += 1) await page.mouse.move(x + 3 * i, y - 14 * Math.sin(i / 6));
    await page.mouse.up();
    expect((await state(page)).drawn.lines.present).toHaveLength(1);
    for (const [dx, dy] of [[0, 60], [30, 40], [60, 60]] as const) await page.mouse.click(x + dx, y + dy);
    await expect(page.getByRole("button", { name: "End the line" })).toBeVisible();
    await expectForEverybody(page, "pen");
    await page.keyboard.press("e");
    await page.getByRole("button", { name: "Next point" }).click();
    await expect(page.getByRole("button", { name: "Delete point" })).toBeEnabled();
    await expectForEverybody(page, "points");
    await page.keyboard.press("Escape");
    await page.getByRole("button", { name: /^Undo/ }).click();
    await page.getByRole("button", { name: /^Undo “Line 2 drawn”/ }).click();
    await page.keyboard.press("t");
    expect((await state(page)).drawn.lines.present.map(({ name }) => name)).toEqual(["Line 1"]);
    await addToPlan(page, /Wise/);
    await addToPlan(page, /^Tumour by the clock/);
    await expectForEverybody(page, "pattern");
    expect((await state(page)).drawing, "a tumour that nobody has said").toBe("reduction");
    await expect(details(page).getByText("Nothing is entered yet: say Side, Hour, From the nipple, Radius.")).toBeVisible();
    await details(page).locator("[data-parameter=side]").last().selectOption("L");
    for (const [name, value] of Object.entries({ clock: "10", distance_mm: "40", radius_mm: "15" })) {
      await numberField(page, name).fill(value);
      await numberField(page, name).press("Tab");
    }
    expect((await state(page)).drawing).toBe(PATTERN);
    await details(page).locator("[data-parameter=depth_mm]").fill("20");
    await details(page).locator("[data-parameter=depth_mm]").press("Tab");
    await addToPlan(page, /^Note/);
    await details(page).getByLabel("Notes").fill("wants it smaller");
    await details(page).getByLabel("Notes").press("Tab");
    await expect(page.locator(".plan-item")).toHaveText([/Wise pattern.*both/, /Tumour, left breast.*20\smm deep/, /Line 1.*cm/, "wants it smaller"]);
    await planItem(page, "Wise").click();
    await expect(page.locator(`.item-details [data-line="wise_L"]`)).toHaveCount(1);
  });

  await test.step("the second scan comes with landmarks and a fit of its own", async () => {
    await page.locator("#add-scan").click();
    await expect(page.getByRole("dialog")).toBeVisible();
    await expectForEverybody(page, "second scan");
    await page.getByRole("dialog", { name: "Add a scan of this patient" }).getByRole("button", { name: /patient, supine/i }).click();
    await expect(page.getByRole("dialog")).toHaveCount(0);
    await expect(page.locator(".thumb .thumb-name")).toHaveText([/^Standing/, /^Supine/]);
    expect(await hook.pickCount(page)).toBe(0);
    expect((await state(page)).drawn.lines.present).toHaveLength(0);
    await hook.ready(page);
    await fitWithExample(page);
    const now = await state(page);
    expect(now.stances.other!.fit!.id).toBe(standing);
    expect(now.fit!.id).not.toBe(standing);
  });
  const supine = (await hook.fit(page))!.id;

  await test.step("carried: the lines on the supine scan are those of the API", async () => {
    await page.keyboard.press("3");
    await expect(page.getByText(/Transferred lines are (one|two|three) fingers? wide/)).toBeVisible();
    const shown = await samePlaces(page, base, standing, supine);
    await expect(page.locator(".doubt-card"), "both are hers").toBeHidden();
    expect(shown.map(({ item, name }) => [item, name])).toEqual(expect.arrayContaining([[expect.any(String), "Line 1"], [expect.any(String), "tumour_L"], [expect.any(String), "wise_L"]]));
    const { drawing, fit } = await state(page);
    expect([drawing, fit!.drawingName], "nothing is made anew on the second body").toEqual(["", null]);
    await expect(page.locator(".plan-item")).toHaveText([/^Tumour, left\d+\smm deep$/, /^Line 1from standing$/, /^Reduction \(Wise pattern\)from standing$/]);
    await planItem(page, "Line 1").click();
    await untilStill(page);
    const full = await hook.picture(page);
    await page.getByLabel("Show Line 1").uncheck();
    expect((await hook.picture(page)).checksum).not.toBe(full.checksum);
    await page.getByLabel("Show Line 1").check();
  });

  await test.step("side by side: both bodies are drawn, turning one turns the other, until unlinked", async () => {
    await thumb(page, "standing").click();
    await expect.poll(() => other(page)).not.toBeNull();
    await expectForEverybody(page, "side by side");
    await untilStill(page);
    const first = (await other(page))!;
    expect(first.picture.colours).toBeGreaterThan(100);
    expect(first.picture.isLost).toBe(false);
    const panes = await Promise.all([page.locator(".other-stage").boundingBox(), page.locator(".stage").boundingBox()]);
    expect(panes[0]!.x, "the first stance stands to the left").toBeLessThan(panes[1]!.x);
    await drag(page, ".stage canvas.view", 90);
    const turned = (await other(page))!;
    expect(turned.picture.checksum).not.toBe(first.picture.checksum);
    expect(degrees(gaze(turned.pose), gaze(first.pose))).toBeGreaterThan(10);
    expect(degrees(gaze(turned.pose), gaze(await pose(page))), "both torsos are seen from the same side").toBeLessThan(3);
    await drag(page, ".other-stage canvas", -60);
    const back = await pose(page);
    expect(degrees(gaze(back), gaze((await other(page))!.pose))).toBeLessThan(3);
    await look(page, "Turn both together");
    await drag(page, ".other-stage canvas", -80);
    expect(await pose(page)).toEqual(back);
    await look(page, "Turn both together");
    await expect.poll(async () => degrees(gaze(await pose(page)), gaze((await other(page))!.pose))).toBeLessThan(3);
  });

  await test.step("the picture holds both stances, as they stand beside each other", async () => {
    const panes = await Promise.all([page.locator(".other-stage").boundingBox(), page.locator(".stage").boundingBox()]);
    const [picture] = await Promise.all([page.waitForEvent("download"), more(page, "Picture of this view")]);
    const png = readFileSync(await picture.path());
    expect(Math.abs(png.readUInt32BE(16) - 2 * (panes[0]!.width + panes[1]!.width))).toBeLessThanOrEqual(4);
  });

  await test.step("the measures are those of the API, as a table and as a file", async () => {
    const asked = page.waitForResponse((answer) => answer.url().endsWith(`/api/fits/${standing}/measures.json?with=${supine}`));
    await page.keyboard.press("4");
    await page.locator("#measures").click();
    const dialog = page.getByRole("dialog", { name: "Measures" });
    await expect(dialog.locator("tbody tr").first()).toBeVisible();
    const file = (await (await asked).json()) as MeasuresFile;
    await untilStill(page); // the panes are lower now: both bodies as large as each other, and nothing looks out below them
    expect(away((await other(page))!.pose)).toBeCloseTo(away(await pose(page)), 3);
    await expect(dialog.locator("thead .group[colspan]")).toHaveText(["Standing", "Supine", "Change: supine − standing"]);
    const names = [...new Set(file.measures.map(({ measure, kind }) => `${measure} ${kind}`))];
    expect(await dialog.locator("tbody tr[data-measure]").count()).toBe(names.length);
    await dialog.locator(".measure-name").first().click();
    await expect(dialog.locator("tr.facts").first()).toContainText(file.measures[0]!.method);
    await expectForEverybody(page, "measures");
    for (const line of measuresTable(file).lines.filter(({ cells }) => cells[0]!.left !== null).slice(0, 6)) {
      const cells = await dialog.locator(`tbody tr[data-measure="${line.measure}"][data-kind="${line.kind}"] td`).allTextContents();
      line.cells.forEach((row) => expect(cells.some((cell) => cell.endsWith(saidOf(row, "left"))), line.measure).toBe(true)); // "not known well enough" may stand before it
    }
    const waiting = page.waitForEvent("download");
    await dialog.getByRole("link", { name: "measures.csv" }).click();
    const path = info.outputPath("measures.csv");
    await (await waiting).saveAs(path);
    expect(readFileSync(path, "utf8").trim().split("\n")).toHaveLength(file.measures.length + 1);
    const report = await page.request.get(base + (await dialog.locator("#report-both").getAttribute("href"))!);
    expect(report.status()).toBe(200);
    expect((await report.body()).subarray(0, 5).toString()).toBe("%PDF-");
    const glb = await (await page.request.get(`${base}/api/fits/${supine}/fitted.glb`)).body();
    for (const name of ["Line 1", "tumour_L", "wise_L"]) expect(glb.includes(`"name":"${name}"`), name).toBe(true);
    await page.keyboard.press("Escape");
    await expect(dialog).toBeHidden();
  });

  await test.step("the printed pages stand there as they will be, and beside them what is not checked; they are printed", async () => {
    await expect(page.locator(".paper img")).not.toHaveCount(0);
    const pages = Number((await page.request.get(`${base}/api/fits/${standing}/report.png?with=${supine}`)).headers()["page-count"]);
    await expect(page.locator(".paper img")).toHaveCount(pages);
    await expect(page.locator(".unchecked li")).toContainText([/^Supine:/, /^Standing:/]);
    await page.evaluate(() => (window.print = () => void (document.title = "printed")));
    await page.getByRole("button", { name: "Print", exact: true }).click();
    await expect.poll(() => page.title()).toBe("printed");
    await page.keyboard.press("3");
    await expect(page.locator(".paper")).toBeHidden();
  });

  await test.step("the page works on the other one at a click, and back", async () => {
    await page.locator(".other-view").click();
    await expect.poll(async () => (await state(page)).fit!.id).toBe(standing);
    expect((await state(page)).drawn.lines.present).toHaveLength(1);
    await expect(thumb(page, "standing")).toHaveAttribute("aria-pressed", "true");
    expect((await state(page)).stances.other!.drawn.onScan!.from).toBe("standing");
  });

  await test.step("drawing goes on, and the other scan follows", async () => {
    await page.keyboard.press("3");
    await page.getByRole("button", { name: "Tumour", exact: true }).click();
    await expect.poll(() => page.evaluate(() => window.__breastrig!.isReady())).toBe(true);
    await untilStill(page);
    const box = (await page.locator(".stage canvas.view").boundingBox())!;
    await page.mouse.click(box.x + box.width * 0.5, box.y + box.height * 0.45);
    expect((await state(page)).drawn.lines.present).toHaveLength(2);
    await expect.poll(async () => (await state(page)).stances.other!.drawn.onScan!.carried.shapes.filter(({ kind }) => kind === "line").length).toBe(2);
    await page.keyboard.press("Escape");
    await expect(page.locator(".top-bar .saved")).toHaveText("Saved");
  });

  await test.step("after a reload both are there, side by side", async () => {
    await page.reload();
    await hook.ready(page);
    await untilFitted(page);
    await expect.poll(() => other(page)).not.toBeNull();
    const now = await state(page);
    expect([now.fit!.id, now.stances.other!.fit!.id]).toEqual([standing, supine]);
    expect(now.drawn.lines.present).toHaveLength(2);
    expect((await other(page))!.picture.colours).toBeGreaterThan(100);
    await expect(page.locator(".thumb .thumb-name")).toHaveText([/^Standing/, /^Supine/]);
    expect(now.drawing).toBe(PATTERN);
    expect(now.drawn).toMatchObject({ note: "wants it smaller", depthMm: 20 });
    const plan = (await (await page.request.get(`${base}/api/fits/${supine}/plan.json`)).json()) as PlanOnScan;
    expect(plan.shapes.find(({ name }) => name === "tumour_L")).toMatchObject({ carried: true, depth_mm: 20 });
    expect(plan.notes.map(({ text }) => text)).toEqual(["wants it smaller"]);
    await expect.poll(async () => (await state(page)).stances.other!.drawn.onScan?.carried.shapes.filter(({ kind }) => kind === "line").length).toBe(2);
  });

  expect((await hook.picture(page)).isLost).toBe(false);

  const link = await test.step("a colleague sees the supine result through a link, with a passcode, and nothing else", async () => {
    await page.locator(".other-view").click();
    await expect.poll(async () => (await state(page)).fit!.id).toBe(supine);
    await openShare(page);
    const dialog = page.getByRole("dialog", { name: "Share this result" });
    await dialog.getByLabel(/^Passcode/).fill("four words of it");
    await dialog.getByLabel("The plan's notes as well").check();
    await dialog.getByRole("button", { name: "Make a link" }).click();
    await expect(dialog.getByLabel("Address of the link")).not.toHaveValue("");
    const address = await dialog.getByLabel("Address of the link").inputValue();
    await page.keyboard.press("Escape");
    await expect(dialog).toBeHidden();
    const colleague = await (await browser.newContext()).newPage();
    await colleague.goto(address);
    await colleague.getByLabel("Passcode").fill("four words of it");
    await colleague.getByRole("button", { name: "Open" }).click();
    await expect(colleague.getByText("fitted.glb")).toBeVisible();
    for (const name of ["Line 1", "tumour_L", "wise_L"]) await expect(colleague.locator(`[data-line="${name}"]`), name).toHaveCount(1);
    await expect(colleague.locator(`[data-line="tumour_L"]`)).toContainText(/carried from another scan, ±\s\d+\smm, 20\smm below the skin/);
    await expect(colleague.getByText("wants it smaller")).toBeVisible();
    const id = colleague.url().split("/").at(-1)!;
    const status = (path: string) => colleague.evaluate(async (at) => (await fetch(at)).status, path);
    expect(await status(`/api/shared/${id}/result.json`)).toBe(200);
    expect(await colleague.evaluate(() => document.body.textContent)).not.toContain(standing);
    return { colleague, id, status };
  });

  await test.step("who asks to delete one stance is told what of the plan goes with it, on the other stance too", async () => {
    await page.keyboard.press("3"); // the printed pages stand before the body
    await page.locator(".other-view").click();
    await expect.poll(async () => (await state(page)).fit!.id).toBe(standing);
    await more(page, "Delete this scan …");
    const question = page.getByRole("dialog", { name: "Delete this scan?" });
    await expect(question).toContainText("Reduction (Wise pattern), Tumour, the note, its fits");
    await expect(question).toContainText("The patient's other scans stay, without what was drawn on this one.");
    await page.keyboard.press("Escape");
    await expect(question).toBeHidden();
  });

  await test.step("deleting both scans leaves nothing: no fit, no link, no file", async () => {
    const { scan, stances } = await state(page);
    const scans = [scan!.info.id, stances.other!.scan!.info.id];
    const { patient } = scan!.info;
    expect(patientFiles(patient).length).toBeGreaterThan(10);
    await page.goto("about:blank"); // a page that still reads what another program deletes would say so
    for (const scan of scans) expect((await page.request.delete(`${base}/api/scans/${scan}`)).status()).toBe(204);
    for (const path of [...scans.map((scan) => `/api/scans/${scan}`), ...[standing, supine].map((fit) => `/api/fits/${fit}`)]) {
      expect((await page.request.get(base + path)).status(), path).toBe(404);
    }
    expect(await link.status(`/api/shared/${link.id}/result.json`)).toBeGreaterThanOrEqual(400);
    await link.colleague.reload();
    await expect(link.colleague.getByText("fitted.glb")).toBeHidden();
    await link.colleague.context().close();
    expect(patientFiles(patient)).toEqual([]);
  });

  expect(troubles).toEqual([]);
});
