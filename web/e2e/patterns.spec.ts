// Patterns under the hand: a handle is dragged on the skin, lines and number follow, the plan keeps what the hand left, and a
// reload brings it back.  And two tools of the hand that make nothing new: the tape, and the mirror.
import { expect, type Page } from "@playwright/test";
import type { MeasuresFile, PatternOnScan, PlanOnScan, StoredPlan, Vector } from "../src/api/types";
import { addToPlan, details, distance, example, fittedExample, hook, numberField, test, trueLandmarks, untilStill } from "./page";

const { state } = hook;
const shown = (page: Page) => page.evaluate(() => window.__breastrig!.state().drawn.live);

async function fitted(page: Page, base: string): Promise<void> {
  await fittedExample(page, base);
  await untilStill(page);
}

async function choose(page: Page, pattern: string): Promise<void> {
  await addToPlan(page, new RegExp(pattern));
}

const handle = (page: Page, name: string) => page.locator(`.handle[data-handle="${name}"]`);

/** Middle of a handle, page pixels. */
async function middle(page: Page, name: string): Promise<{ x: number; y: number }> {
  await expect(handle(page, name)).toBeVisible();
  await untilStill(page);
  const box = (await handle(page, name).boundingBox())!;
  return { x: box.x + box.width / 2, y: box.y + box.height / 2 };
}

const numberOf = (text: string | null): number => Number(/(-?[\d.]+)/.exec((text ?? "").split(":").at(-1)!)![1]);

test("the new nipple is dragged: line and number follow, the plan keeps them, undo and reload know them", async ({ page, base, troubles }) => {
  await fitted(page, base);
  await choose(page, "vertical");
  const name = "values/new_nipple_L";
  const start = await middle(page, name);
  const before = numberOf(await handle(page, name).getAttribute("aria-label"));
  const field = numberField(page, "nipple_above_fold_mm");
  await expect(page.locator(".is-forced"), "of each side what is drawn; dashed where the body did not let it be as asked").toHaveCount(4);
  expect(Math.abs(Number(await field.inputValue()) - before), "field and handle say what is drawn").toBeLessThan(1);
  await expect(details(page).getByText(/^Dashed: width: 60\smm asked, drawn otherwise on this skin\. The nipple is already above the fold, and this pattern never lowers it\.$/)).toBeVisible();
  expect(Number(await numberField(page, "width_mm", "R").inputValue()), "limbs that bend with the skin are nearer to each other than was asked for").toBeLessThan(60);
  await expect(numberField(page, "areola_mm", "R")).toHaveValue("42");
  const plan = async () => (await (await page.request.get(base + (await state(page)).scan!.info.links.plan)).json()) as StoredPlan;
  const parameters = async () => (await plan()).items.map((item) => (item.kind === "pattern" ? item.parameters! : {}))[0]!;
  await expect.poll(async () => (await state(page)).drawn.onScan?.patterns.shapes.some(({ name: line }) => line === "vertical_L")).toBe(true);
  const lineBefore = (await state(page)).drawn.onScan!.patterns.shapes.find(({ name: line }) => line === "vertical_L")!.points;

  await test.step("while it is dragged the line and the number move, and nothing is written", async () => {
    const { version } = await plan();
    await page.mouse.move(start.x, start.y);
    await page.mouse.down();
    for (let i = 1; i <= 8; i += 1) await page.mouse.move(start.x, start.y - 4 * i);
    await expect.poll(async () => (await shown(page))?.dragged !== null && (await shown(page))?.limit).toBe("New nipple above the fold stops at 40 mm.");
    const live = (await shown(page))!;
    const line = live.dragged!.patterns.shapes.find(({ name: each }) => each === "vertical_L")!.points;
    expect(line).not.toEqual(lineBefore);
    await expect(handle(page, name).locator(".handle-says")).toHaveText("New nipple above the fold 40\u00a0mm, New nipple beside the meridian 0\u00a0mm, left. New nipple above the fold stops at 40 mm.");
    await expect(field).toHaveValue("40");
    expect(before).toBeLessThan(40);
    expect((await plan()).version).toBe(version);
  });

  await test.step("when the hand lets go the plan has it, and its lines are the ones that were seen", async () => {
    const seen = (await shown(page))!.dragged!.patterns.shapes.find(({ name: each }) => each === "vertical_L")!.points;
    await page.mouse.up();
    await expect.poll(parameters).toEqual({ nipple_above_fold_mm: 40 });
    const fit = (await hook.fit(page))!.id;
    const kept = (await (await page.request.get(`${base}/api/fits/${fit}/plan.json`)).json()) as PlanOnScan;
    expect(kept.shapes.find(({ name: each }) => each === "vertical_L")!.points).toEqual(seen);
    await expect.poll(async () => (await state(page)).drawn.onScan?.patterns.shapes.find(({ name: each }) => each === "vertical_L")?.points).toEqual(seen);
  });

  await test.step("it is one step to undo", async () => {
    await page.keyboard.press("z");
    await expect(page.locator(".undone")).toHaveText("Undone: new nipple above the fold 40\u00a0mm instead of 0\u00a0mm.");
    await expect.poll(parameters).toEqual({});
    await page.keyboard.press("Shift+Z");
    await expect.poll(parameters).toEqual({ nipple_above_fold_mm: 40 });
  });

  await test.step("arrow keys move a handle by a millimetre, with Shift by five", async () => {
    const width = "values/width_first_L";
    await middle(page, width);
    await handle(page, width).focus();
    await page.keyboard.press("ArrowLeft");
    await expect(handle(page, width)).toHaveAttribute("aria-label", "Width, left: 61\u00a0mm");
    await page.keyboard.press("Shift+ArrowRight");
    await expect.poll(parameters).toEqual({ nipple_above_fold_mm: 40, width_mm: 56 });
  });

  await test.step("a reload keeps it", async () => {
    await page.reload();
    await hook.ready(page);
    await page.keyboard.press("3");
    await expect(handle(page, "values/width_first_L")).toHaveAttribute("aria-label", "Width, left: 56\u00a0mm");
    expect((await state(page)).drawing).toBe("vertical:nipple_above_fold_mm=40,width_mm=56");
    await expect.poll(async () => (await state(page)).drawn.onScan?.patterns.shapes.length).toBe(6);
  });

  await test.step("right and left are set apart, by field and hand, and put together again", async () => {
    await details(page).getByRole("button", { name: "Set right and left apart" }).click();
    await numberField(page, "areola_mm", "R").fill("38");
    await numberField(page, "areola_mm", "R").press("Enter");
    await expect.poll(parameters).toMatchObject({ areola_mm_right: 38, areola_mm_left: 42, width_mm_left: 56 });
    await expect(handle(page, "values/areola_R")).toHaveAttribute("aria-label", "New areola, right: 38\u00a0mm");
    await expect(handle(page, "values/areola_L")).toHaveAttribute("aria-label", "New areola, left: 42\u00a0mm");
    await handle(page, "values/areola_L").focus();
    await page.keyboard.press("Shift+ArrowRight");
    await expect.poll(parameters).toMatchObject({ areola_mm_right: 38, areola_mm_left: 47 });
    await expect(numberField(page, "areola_mm", "L")).toHaveValue("47");
    await expect(numberField(page, "areola_mm", "R")).toHaveValue("38");
    await details(page).getByRole("button", { name: "Both as right" }).click();
    await expect.poll(parameters).toEqual({ areola_mm: 38, nipple_above_fold_mm: 40, width_mm: 56 });
    await expect(numberField(page, "areola_mm", "L")).toHaveValue("38");
    await page.keyboard.press("Control+Z");
    await expect(page.locator(".undone")).toHaveText("Undone: one number for right and left.");
    await page.keyboard.press("Control+Shift+Z");
    await expect.poll(parameters).toMatchObject({ areola_mm: 38 });
  });

  await test.step("the wheel zooms over a handle as it does beside it", async () => {
    const [at, other] = [await middle(page, "values/width_first_L"), await middle(page, "values/width_first_R")];
    await page.mouse.move(at.x, at.y);
    await page.mouse.wheel(0, -300);
    await expect.poll(async () => Math.abs((await middle(page, "values/width_first_L")).x - (await middle(page, "values/width_first_R")).x)).toBeGreaterThan(1.05 * Math.abs(at.x - other.x));
  });
  expect(troubles).toEqual([]);
});

test("only the newest place waits, Escape puts everything back, a tumour follows the finger; the tape leaves nothing, a line is mirrored", async ({ page, base, troubles }) => {
  await fitted(page, base);
  await test.step("the chosen pattern and all its numbers are seen at once on a laptop; it is one row of the plan", async () => {
    await addToPlan(page, /Wise/);
    for (const viewport of [{ width: 1440, height: 900 }, { width: 1280, height: 720 }]) {
      await page.setViewportSize(viewport);
      await expect(page.locator(".plan-item")).toHaveText([/^Reduction \(Wise pattern\)/]);
      for (const name of ["areola_mm", "limb_mm", "nipple_above_fold_mm"]) for (const side of ["R", "L"] as const) await expect(numberField(page, name, side)).toBeInViewport({ ratio: 1 });
    }
    await details(page).getByText("side, angles, position, new fold").click();
    await expect(page.locator(".numbers [data-parameter]:visible")).toHaveCount(15);
  });
  await details(page).getByRole("button", { name: "Take Reduction (Wise pattern) out of the plan" }).click();
  await expect(page.locator(".plan-item")).toHaveCount(0);
  await addToPlan(page, /^Tumour by the clock/);
  await details(page).locator("[data-parameter=side]").last().selectOption("L");
  for (const [name, value] of Object.entries({ clock: "12", distance_mm: "40", radius_mm: "15" })) {
    await numberField(page, name).fill(value);
    await numberField(page, name).press("Tab");
  }
  const name = "tumour/centre_L";
  const start = await middle(page, name);
  const asked: Vector[] = [];
  let answer!: () => void;
  const moved = new Promise<void>((done) => (answer = done)); // the service answers the first place once the hand was at the last
  await page.route("**/pattern", async (route) => {
    const { drag } = route.request().postDataJSON() as { drag?: { to: Vector } };
    if (drag) asked.push(drag.to);
    if (drag) await moved;
    await route.continue();
  });
  const before = (await state(page)).drawing;
  await page.mouse.move(start.x, start.y);
  await page.mouse.down();
  for (let i = 1; i <= 20; i += 1) await page.mouse.move(start.x + i, start.y + i);
  const last = await page.evaluate(([x, y]) => window.__breastrig!.pickAt(x!, y!)!.point, [start.x + 20, start.y + 20]);
  await expect.poll(() => asked.length).toBe(1);
  answer();
  await expect.poll(() => asked.length).toBe(2);
  expect(distance(asked[1]!, last)).toBeLessThan(2);
  await expect.poll(async () => (await shown(page))!.dragged !== null).toBe(true);
  await page.keyboard.press("Escape");
  await page.mouse.up();
  expect((await state(page)).drawing).toBe(before);

  await expect(handle(page, name)).toHaveAttribute("aria-label", /^Hour 12 o'clock, From the nipple 40.mm, left$/);
  const again = await middle(page, name);
  await page.mouse.move(again.x, again.y);
  await page.mouse.down();
  await page.mouse.move(again.x - 10, again.y, { steps: 4 });
  await page.mouse.up();
  await expect.poll(async () => (await state(page)).drawing).not.toBe(before);
  expect((await state(page)).drawing).toMatch(/clock=11\./);
  const fit = (await hook.fit(page))!.id;
  const bad = await page.request.post(`${base}/api/fits/${fit}/pattern`, { data: { name: "tumour", parameters: { side: "L", clock: 12, distance_mm: 40, radius_mm: 15 }, side: "L" } });
  expect(((await bad.json()) as PatternOnScan).shapes).toHaveLength(1);
  await page.unrouteAll({ behavior: "wait" }); // the last drawing may still be on its way
  await details(page).getByRole("button", { name: /^Take Tumour.* out of the plan/ }).click();
  await page.keyboard.press("f");
  await untilStill(page);

  const truth = trueLandmarks();
  const drawn = async () => (await state(page)).drawn;

  await test.step("the tape", async () => {
    await page.keyboard.press("m");
    const [from, to] = [await hook.project(page, truth.suprasternal_notch!), await hook.project(page, truth.nipple_L!)];
    await page.mouse.click(from.x, from.y);
    await page.mouse.click(to.x, to.y);
    await expect.poll(async () => (await drawn()).tape!.legs[0]!.mm).not.toBeNull();
    const tape = (await drawn()).tape!;
    const straight = distance(tape.places[0]!, tape.places[1]!);
    const along = tape.legs[0]!.mm!;
    expect(along).toBeGreaterThan(straight);
    const { measures } = (await (await page.request.get(base + (await state(page)).fit!.links.measures)).json()) as MeasuresFile;
    const said = measures.find(({ measure, kind }) => measure === "notch_nipple" && kind === "along the skin")!.left!;
    expect(Math.abs(along - said), "the table's number, but for where the clicks fell").toBeLessThan(4);
    await expect(page.locator(".tape-length")).toHaveText(new RegExp(`${Math.round(along)}.mm in all`));
    await page.keyboard.press("Escape");
    expect((await drawn()).tape!.isEnded).toBe(true);
    await page.keyboard.press("Escape");
    expect((await drawn()).tape).toBeNull();
    expect((await drawn()).lines.present).toHaveLength(0);
  });

  await test.step("the mirror", async () => {
    await page.keyboard.press("p");
    const place = await hook.project(page, truth.nipple_L!);
    await page.mouse.move(place.x + 4, place.y - 30);
    await page.mouse.down();
    for (let i = 1; i <= 12; i += 1) await page.mouse.move(place.x + 4 + 2 * i, place.y - 30 - i);
    await page.mouse.up();
    await page.keyboard.press("Escape");
    await page.getByRole("button", { name: "Mirror Line 1 to the other side" }).click();
    const [own, mirrored] = (await drawn()).lines.present;
    expect(mirrored!.name).toBe("Line 1, mirrored");
    expect(mirrored!.points.length).toBeGreaterThan(5);
    const middleOf = (points: readonly Vector[]): Vector => [0, 1, 2].map((axis) => points.reduce((sum, point) => sum + point[axis]!, 0) / points.length) as Vector;
    const [here, there] = [middleOf(own!.points), middleOf(mirrored!.points)];
    const { median_plane: plane, scan } = (await state(page)).fit!.result!;
    const toMm = scan.unit === "m" ? 1000 : 1;
    const off = plane!.normal.reduce((sum, n, axis) => sum + n * here[axis]!, 0) - plane!.offset * toMm;
    const reflected = here.map((value, axis) => value - 2 * off * plane!.normal[axis]!) as Vector;
    expect(distance(reflected, there), "in the service's median plane, then on the skin that is there").toBeLessThan(15);
    expect(distance(there, truth.nipple_R!)).toBeLessThan(distance(there, truth.nipple_L!));
    await expect(page.locator(".top-bar .saved")).toHaveText("Saved");
  });
  expect(troubles).toEqual([]);
});

test("a tab that is looked at again says what was written in another one, and shows it when asked to", async ({ page, base, troubles, context }) => {
  await page.goto(base);
  await example(page);
  await hook.ready(page);
  const second = await context.newPage();
  const asked: string[] = [];
  second.on("request", (request) => asked.push(new URL(request.url()).pathname));
  await second.goto(page.url());
  await hook.ready(second);
  expect(asked, "of no other patients").not.toContain("/api/patients");
  await second.keyboard.press("3");
  await untilStill(second);
  await second.keyboard.press("p");
  const place = await hook.project(second, trueLandmarks().nipple_L!);
  await second.mouse.move(place.x, place.y - 30);
  await second.mouse.down();
  for (let i = 1; i <= 12; i += 1) await second.mouse.move(place.x + 2 * i, place.y - 30 - i);
  await second.mouse.up();
  await expect(second.locator(".top-bar .saved")).toHaveText("Saved");
  await page.bringToFront();
  await page.evaluate(() => window.dispatchEvent(new Event("focus"))); // without windows none comes by itself
  await expect(page.getByText("The plan was changed in another tab or by somebody else.")).toBeVisible();
  expect((await state(page)).drawn.lines.present).toHaveLength(0);
  await page.getByRole("button", { name: "Show it as it is now" }).click();
  await expect.poll(async () => (await state(page)).drawn.lines.present.map(({ name }) => name)).toEqual(["Line 1"]);
  await expect(page.getByText("The plan was changed in another tab or by somebody else.")).toBeHidden();
  await second.close();
  expect(troubles).toEqual([]);
});

test("a fit that was asked for a pattern which does not fit on this breast is kept, and says what to change", async ({ page, base, troubles }) => {
  await fittedExample(page, base, { step: "body", fit: { drawing: "reduction:limb_mm=80" } });
  expect((await hook.fit(page))!.state).toBe("done");
  const said = page.getByText('Not drawn: Reduction (Wise pattern). No room on the left: limbs of 80 mm reach the fold. Choose shorter limbs');
  await expect(said).toBeVisible();
  expect(troubles).toEqual([]);
});
