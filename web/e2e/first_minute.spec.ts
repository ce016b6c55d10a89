// The first minute: three files of one woman dropped at once, what is worth it checked by keys, Wise drawn, the pages printed.  What is
// true of the virtual woman is known, so that every place is measured against it.
import { execFileSync } from "node:child_process";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { expect, type Page } from "@playwright/test";
import type { PlanOnScan, Vector } from "../src/api/types";
import { addToPlan, distance, drop, hook, planItem, test, until, untilFitted, untilStill } from "./page";
import { mmFrom } from "../src/ui/units";
import { findPython, helper } from "./service";

test.use({ fitsAtOnce: true, viewport: { width: 1280, height: 720 } });

interface Truth {
  readonly skin: readonly Vector[]; // mm, the same vertices in both stances
  readonly landmarks: Readonly<Record<string, Vector>>;
  readonly lesion?: Vector;
}
type Stance = "standing" | "supine";

let folder = "";
let truth: Record<Stance, Truth>;
test.beforeAll(({}, info) => {
  folder = info.outputPath("files");
  const { path, env } = helper("first_minute_files.py");
  execFileSync(findPython(), [path, folder], { env, stdio: "inherit" });
  truth = JSON.parse(readFileSync(join(folder, "truth.json"), "utf8")) as Record<Stance, Truth>;
});

const state = (page: Page) => page.evaluate(() => window.__breastrig!.state());
const next = (page: Page) => page.locator("#next");

/** A place of the skin in the other stance: moved as the three true vertices around it are. */
function followed(at: Vector, from: Truth, to: Truth): Vector {
  const near = from.skin.map((vertex, i) => ({ i, mm: Math.max(0.01, distance(vertex, at)) })).sort((a, b) => a.mm - b.mm).slice(0, 3);
  const total = near.reduce((sum, { mm }) => sum + 1 / mm, 0);
  return [0, 1, 2].map((axis) => near.reduce((sum, { i, mm }) => sum + to.skin[i]![axis]! / mm / total, 0)) as Vector;
}

/** What is asked now: the landmark's name and where its dot is, mm. */
const asked = (page: Page) =>
  page.evaluate(() => {
    const { tour } = window.__breastrig!.state().checks;
    const step = tour?.steps[tour.at];
    return tour && step?.kind === "point" ? { name: step.check.name, dot: tour.moved ?? step.check.place } : null;
  });

/** Moves the dot by arrow keys to where the landmark truly is, and says yes; to the end of the tour.  How many there were. */
async function answer(page: Page, of: Truth): Promise<number> {
  let answered = 0;
  for (let step = await asked(page); step; answered += 1) {
    await expect(page.getByRole("button", { name: /^Yes, it is here/ })).toBeFocused();
    await untilStill(page);
    const right = of.landmarks[step.name]!;
    const goal = await hook.project(page, right);
    const beside = await Promise.all([0, 1, 2].map((axis) => hook.project(page, right.map((mm, i) => mm + (i === axis ? 10 : 0)) as Vector)));
    const pixels = Math.hypot(...beside.flatMap(({ x, y }) => [x - goal.x, y - goal.y])) / 10 / Math.SQRT2; // of a millimetre: the three axes, as they are seen
    for (let presses = 0; presses < 60; presses += 1) {
      const { dot } = (await asked(page))!;
      const at = await hook.project(page, dot);
      const [across, down] = [(goal.x - at.x) / pixels, (goal.y - at.y) / pixels];
      const far = Math.max(Math.abs(across), Math.abs(down));
      if (far < 0.7) break;
      const way = Math.abs(across) > Math.abs(down) ? (across > 0 ? "Right" : "Left") : down > 0 ? "Down" : "Up";
      await page.keyboard.press(`${far > 4 ? "Shift+" : ""}Arrow${way}`);
    }
    expect(distance((await asked(page))!.dot, right), `${step.name}, mm off`).toBeLessThan(4);
    await page.keyboard.press("Enter");
    await expect.poll(async () => (await asked(page))?.name).not.toBe(step.name);
    step = await asked(page);
  }
  await until(page, () => window.__breastrig!.state().checks.tour === null);
  await untilFitted(page);
  return answered;
}

test("three files are dropped, points checked, Wise drawn and printed, and every place is true", async ({ page, base, troubles }, info) => {
  let dialogs = 0;
  await page.exposeFunction("dialogMet", () => void (dialogs += 1));
  await page.addInitScript(() => {
    const { value: open } = Object.getOwnPropertyDescriptor(HTMLDialogElement.prototype, "showModal") as { value: (this: HTMLDialogElement) => void };
    HTMLDialogElement.prototype.showModal = function () {
      (window as unknown as { dialogMet: () => void }).dialogMet();
      open.call(this);
    };
  });
  const open = new Set<object>(); // requests about plan and checks
  let heard = 0;
  const isOfPlan = (url: string): boolean => /\/(checks|plan\.json|plan)$/.test(url);
  page.on("request", (request) => isOfPlan(request.url()) && open.add(request));
  for (const end of ["requestfinished", "requestfailed"] as const) page.on(end as "requestfinished", (request) => open.delete(request) && (heard = Date.now()));
  const untilKnown = () => expect.poll(() => open.size === 0 && Date.now() - heard > 1000, "the plan is carried and its checks are known").toBe(true);
  await page.goto(base);
  await expect(page.getByText("Drop the patient's scans anywhere on this page")).toBeVisible();
  const began = Date.now();
  const reached: string[] = [];
  const reach = async (what: string): Promise<void> => {
    reached.push(`${what} ${((Date.now() - began) / 1000).toFixed(1)} s`);
    await page.screenshot({ path: info.outputPath(`${reached.length} ${what}.png`) });
  };
  await drop(page, ["standing.ply", "supine.ply", "mri.nii.gz"].map((name) => ({ name, path: join(folder, name) })));
  await expect(page.locator(".thumb .thumb-name")).toHaveText([/^Standing/, /^Supine/, /^MRI/]);
  await reach("one patient");
  await untilFitted(page);
  await until(page, () => window.__breastrig!.state().stances.other?.fit?.state === "done");
  await reach("fitted");

  await test.step("one patient, nobody placed a landmark, one advice", async () => {
    const { scan, stances, fit } = await state(page);
    expect(stances.other!.scan!.info.patient).toBe(scan!.info.patient);
    expect([fit!.result!.stance, stances.other!.fit!.result!.stance]).toEqual(["standing", "supine"]);
    expect(await hook.pickCount(page)).toBe(0);
    await expect(page.locator(".verdict")).toContainText(/Lines on the breasts are (one finger|two fingers|three fingers) wide\s±\s\d+\smm\./);
    await expect(page.locator(".verdict"), "the number stands there").not.toContainText("far off");
  });

  let checked = 0;
  /** All points that the main button offers, one scan after the other. */
  const answerAll = async (): Promise<void> => {
    await untilKnown();
    while ((await next(page).textContent())!.startsWith("Check")) {
      const offered = Number(/\d/.exec((await next(page).textContent())!)![0]);
      await next(page).press("Enter");
      await expect.poll(() => asked(page)).not.toBeNull();
      const { fit, step } = await state(page);
      const answered = await answer(page, truth[fit!.result!.stance as Stance]);
      expect(answered, "as many as were offered").toBe(offered);
      checked += answered;
      if (step === "body") await expect(page.locator(".verdict-outcome")).toHaveText(/^The lines have narrowed/);
      await untilKnown();
    }
  };
  await test.step("what is worth checking before anything is drawn", async () => {
    await answerAll();
    await expect(next(page)).toHaveText("Draw the plan");
    await reach("body");
  });

  await test.step("Wise is drawn, and lies on both stances, with the MRI's lesion", async () => {
    await next(page).press("Enter");
    await addToPlan(page, /Wise/);
    await until(page, () => {
      const { drawn, stances } = window.__breastrig!.state();
      return [drawn, stances.other!.drawn].every(({ onScan }) => onScan?.plan.shapes.some(({ name }) => name === "wise_L") && onScan.plan.lesions.length === 1);
    });
    await reach("Wise");
  });

  await test.step("what else is worth checking for these lines, on either scan", async () => {
    await answerAll();
    await reach(`ready after ${checked} checks`);
    expect(checked).toBeGreaterThanOrEqual(2);
    await expect(next(page)).toHaveText("Print the plan");
  });

  await test.step("every place is true: the same skin in both stances, the lesion, sides", async () => {
    const { drawn, stances, fit } = await state(page);
    const plans = Object.fromEntries([[fit!.result!.stance, drawn.onScan!.plan], [stances.other!.fit!.result!.stance, stances.other!.drawn.onScan!.plan]]) as Record<Stance, PlanOnScan>;
    const mm = ({ unit }: PlanOnScan, at: readonly number[]): Vector => at.map((value) => mmFrom(value, unit)) as Vector;
    const off: { mm: number; radius: number }[] = [];
    for (const shape of plans.standing.shapes.filter(({ kind }) => kind === "pattern")) {
      const side = shape.name.endsWith("_L") ? "L" : "R";
      const carried = plans.supine.shapes.find(({ name }) => name === shape.name)!;
      expect([shape.carried, carried.carried]).toEqual([false, true]);
      const line = carried.points.map((at, i) => ({ at: mm(plans.supine, at), radius: carried.error_mm?.[i] ?? Infinity }));
      for (const [i, at] of shape.points.entries()) {
        if (shape.bridged[i]) continue;
        const place = mm(plans.standing, at);
        const [own, others] = ["L", "R"].sort((each) => (each === side ? -1 : 1)).map((each) => distance(place, truth.standing.landmarks[`nipple_${each}`]!));
        expect(own, `${shape.name} is on its side`).toBeLessThan(others!);
        const there = followed(place, truth.standing, truth.supine);
        const nearest = line.map(({ at: on, radius }) => ({ mm: distance(on, there), radius })).sort((a, b) => a.mm - b.mm)[0]!;
        off.push(nearest);
      }
    }
    const sorted = off.map((each) => each.mm).sort((a, b) => a - b);
    const within = off.filter((each) => each.mm <= each.radius).length / off.length;
    info.annotations.push({ type: "carried Wise", description: `${off.length} points, ${sorted[Math.floor(off.length / 2)]!.toFixed(1)} mm off at the median, ${sorted[Math.floor(0.9 * off.length)]!.toFixed(1)} at 90 %, ${(100 * within).toFixed(0)} % within their radius` });
    expect(within, "the band holds nine of ten").toBeGreaterThan(0.9);
    expect(sorted[Math.floor(off.length / 2)]!, "mm, median").toBeLessThan(10);

    const [here, there] = [plans.standing.lesions[0]!, plans.supine.lesions[0]!];
    const gap = distance(mm(plans.standing, here.center), truth.standing.lesion!);
    info.annotations.push({ type: "lesion", description: `standing ${gap.toFixed(1)} mm off, ± ${here.error_mm}` });
    expect(gap, "within what is said").toBeLessThan(here.error_mm!);
    const [left, right] = ["nipple_L", "nipple_R"].map((name) => distance(mm(plans.supine, there.center), truth.supine.landmarks[name]!));
    expect(left).toBeLessThan(60);
    expect(right!).toBeGreaterThan(2 * left!);
    await expect(planItem(page, "Lesion 1")).toContainText(/\d+\smm deep/);
  });

  await test.step("the paper is shown and printed, and the report is a PDF", async () => {
    await next(page).press("Enter");
    await expect(page.locator(".paper img").first()).toBeVisible();
    const report = await page.request.get(base + (await page.locator("#report").getAttribute("href"))!);
    expect((await report.body()).subarray(0, 5).toString()).toBe("%PDF-");
    await page.evaluate(() => (window.print = () => void (document.title = "printed")));
    await page.getByRole("button", { name: "Print", exact: true }).press("Enter");
    await expect.poll(() => page.title()).toBe("printed");
    await reach("printed");
  });
  expect(dialogs, "dialogs met").toBe(0);
  info.annotations.push({ type: "seconds since the drop", description: reached.join("; ") });
  console.log(info.annotations.map(({ type, description }) => `${type}: ${description}`).join("\n"));
  expect(troubles).toEqual([]);
});
