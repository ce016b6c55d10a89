// The guided check, by keys alone: the eye flies to the point, the dot is moved by a millimetre, Escape leaves; the answers narrow the
// halo, and the page says so.
import { expect, type Page } from "@playwright/test";
import type { Checks, Fit, Vector } from "../src/api/types";
import "./words"; // before those that ask for some
import * as text from "../src/checks/text";
import { overlaps, seriousFindings, smallTargets } from "./audit";
import { addToPlan, distance, hook, test, until, untilFitted, untilStill } from "./page";
import { inTheme } from "./states";

const tour = (page: Page) => page.evaluate(() => window.__breastrig!.state().checks.tour);
const halo = (page: Page) => page.evaluate(() => window.__breastrig!.halo());
const pose = (page: Page) => page.evaluate(() => window.__breastrig!.pose());

test("points that are worth it are checked by keys alone, and the halo narrows", async ({ page, base, troubles }) => {
  const post = async (path: string, data: object = {}) => (await (await page.request.post(base + path, { data })).json()) as { id: string };
  const scan = await post("/api/examples/supine");
  const { id } = await post("/api/fits", { scan: scan.id });
  await expect.poll(async () => ((await (await page.request.get(`${base}/api/fits/${id}`)).json()) as Fit).state).toBe("done");
  await page.goto(`${base}/#scan=${scan.id}&fit=${id}&step=plan`);
  await hook.ready(page);
  await untilFitted(page);
  await addToPlan(page, /Wise/);
  await until(page, () => window.__breastrig!.halo());
  await page.keyboard.press("1");
  const checks = (await (await page.request.get(`${base}/api/fits/${id}/checks`)).json()) as Checks;
  expect([checks.worth_it, checks.lines]).toEqual([true, "plan"]);
  const count = checks.checks.length;
  const widest = checks.line_error_mm!;
  const before = (await halo(page))!;

  await test.step("the verdict and the main button say how many", async () => {
    await expect(page.locator(".verdict-level")).toHaveText(count === 1 ? "One point first" : /points first$/);
    await expect(page.locator("#next")).toHaveText(new RegExp(`^Check ${count} points?\\s${10 * count}\\ss$`));
    const onLines = await page.locator("#next span").evaluate((words, longest) => {
      const [said, shown] = [words.textContent, Object.assign(words, { textContent: longest }).getClientRects().length];
      words.textContent = said;
      return shown;
    }, `${text.checks.begin(3, "standing 2")}\u2002${text.checks.lasts(3)}`);
    expect(onLines, "the longest that it says stands on one line").toBe(1);
    await expect(page.locator(".stage .sureness")).toContainText(new RegExp(`^(one|two|three) fingers? wide±\\s${Math.round(widest)}\\smm`));
  });

  await test.step("the eye flies to the point, square to the skin, until single millimetres show", async () => {
    await page.locator("#next").press("Enter");
    const card = page.locator(".check-card");
    await expect(card.getByRole("heading")).toHaveText(new RegExp(checks.checks[0]!.label, "i"));
    await expect(card).toContainText(/Is the dot there\?/);
    await expect(page.getByRole("button", { name: /^Yes, it is here/ })).toBeFocused();
    await expect(page.getByText("The same place on the model")).toBeVisible();
    await untilStill(page);
    const [x, y, z] = checks.checks[0]!.place;
    const ends = await Promise.all([[0, 0, 0], [10, 0, 0], [0, 10, 0], [0, 0, 10]].map((by) => hook.project(page, [x + by[0]!, y + by[1]!, z + by[2]!])));
    const across = Math.max(...ends.slice(1).map((end) => Math.hypot(end.x - ends[0]!.x, end.y - ends[0]!.y)));
    expect(across, "ten millimetres, in pixels").toBeGreaterThan(30);
    await expect(page.locator("#side-body"), "the card has the panel's place").toBeHidden();
    expect.soft(await smallTargets(page)).toEqual([]);
    expect.soft(await overlaps(page)).toEqual([]);
    expect.soft(await seriousFindings(page)).toEqual([]);
    const insetLight = () => page.locator(".check-inset canvas").evaluate((canvas) => [...(canvas as HTMLCanvasElement).getContext("2d")!.getImageData(0, 0, 216, 216).data].reduce((sum, each) => sum + each, 0) / (4 * 216 * 216));
    const inLight = await insetLight();
    await inTheme(page, "dark");
    expect.soft(await seriousFindings(page, { runOnly: ["color-contrast"] }), "contrast in the dark").toEqual([]);
    await expect.poll(insetLight, "the model's picture is in the theme's colours too").toBeLessThan(inLight - 10);
    await inTheme(page, "light");
    await expect.poll(insetLight, "and as bright as before").toBeCloseTo(inLight, 0);
  });

  await test.step("one tap shows the same point from below, another one from the side, and again square to the skin", async () => {
    const square = await pose(page);
    const tap = async (name: string) => {
      await page.getByRole("button", { name }).click();
      await untilStill(page);
      const { eye, target } = await pose(page);
      expect(distance(target, square.target), "the point stays in the middle").toBeLessThan(1e-3);
      await expect(page.locator(".overlay > .check-dot")).not.toHaveClass(/is-hidden/);
      const way = eye.map((value, axis) => value - target[axis]!);
      return way.map((value) => value / Math.hypot(...way)) as unknown as Vector;
    };
    expect((await tap("From below"))[1]).toBeLessThan(-0.4);
    const side = await tap("From the side");
    expect(side[0] * (checks.checks[0]!.name.endsWith("_R") ? -1 : 1)).toBeGreaterThan(0.6);
    await expect(page.getByRole("button", { name: "From the side" })).toHaveAttribute("aria-pressed", "true");
    await tap("From the side");
    expect(distance((await pose(page)).eye, square.eye)).toBeLessThan(1e-3);
    await page.getByRole("button", { name: /^Yes, it is here/ }).focus();
  });

  await test.step("an arrow key moves the dot by a millimetre, and the halo shows what is expected", async () => {
    await page.keyboard.press("ArrowUp");
    const { moved } = (await tour(page))!;
    const far = Math.hypot(...moved!.map((value, axis) => value - checks.checks[0]!.place[axis]!));
    expect(far).toBeGreaterThan(0.6);
    expect(far).toBeLessThan(2);
    await expect(page.getByText("Is it here?")).toBeVisible();
    await expect.poll(async () => (await halo(page))![1] / before[1]).toBeCloseTo(Math.min(1, checks.checks[0]!.line_error_mm / widest), 2);
  });

  await test.step("Escape leaves: the eye is back, nothing was placed", async () => {
    await page.keyboard.press("Escape");
    await expect(page.locator(".check-card")).toBeHidden();
    await expect(page.locator("#next")).toBeFocused();
    await untilStill(page);
    expect(await hook.pickCount(page)).toBe(0);
    expect(await halo(page)).toEqual(before);
  });

  await test.step("a yes to each: the fit that knows them is made, the halo is narrower, and the page says so", async () => {
    const { eye } = await pose(page);
    await page.keyboard.press("Enter");
    for (let at = 1; at <= count; at += 1) {
      await expect(page.locator(".check-head")).toContainText(`Point ${at} of ${count}`);
      await page.keyboard.press("Enter");
    }
    await until(page, () => window.__breastrig!.state().checks.outcome);
    expect(await hook.pickCount(page)).toBe(count);
    expect((await hook.fit(page))!.id).not.toBe(id);
    await expect(page.getByRole("status").filter({ hasText: /The lines have narrowed: they were .* and are/ }).first()).toBeAttached();
    await untilStill(page);
    expect((await halo(page))![1]).toBeLessThan(before[1] - 1);
    const now = (await pose(page)).eye;
    expect(Math.hypot(...now.map((value, axis) => value - eye[axis]!)), "the camera is back").toBeLessThan(0.01);
  });
  expect(troubles).toEqual([]);
});
