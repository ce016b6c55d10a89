// The full canvas on a tablet with a stylus: the pen draws whatever its pressure, the hand that holds it does nothing, fingers
// turn; every tool is large enough, and Done leads back.
import { type CDPSession, expect } from "@playwright/test";
import { overlaps, seriousFindings, smallTargets } from "./audit";
import { distance, example, hook, tap, test, untilStill } from "./page";
import { inTheme } from "./states";

test.use({ hasTouch: true, viewport: { width: 1024, height: 768 } });

const TARGET_PX = 44;
type Point = readonly [x: number, y: number];

/** What a stylus does: `press` rises along the way. */
async function stroke(session: CDPSession, from: Point, to: Point, press: (share: number) => number): Promise<void> {
  const pen = (type: string, [x, y]: Point, force: number, buttons: number) =>
    session.send("Input.dispatchMouseEvent", { type: type as "mouseMoved", x, y, button: "left", buttons, clickCount: 1, pointerType: "pen", force });
  await pen("mousePressed", from, press(0), 1);
  for (let i = 1; i <= 16; i += 1) await pen("mouseMoved", [from[0] + ((to[0] - from[0]) * i) / 16, from[1] + ((to[1] - from[1]) * i) / 16], press(i / 16), 1);
  await pen("mouseReleased", to, 0, 0);
}

test("a stylus draws, its hand does nothing, fingers turn; Done leads back", async ({ page, base, troubles, context }) => {
  const session = await context.newCDPSession(page);
  const lines = () => page.evaluate(() => window.__breastrig!.state().drawn.lines.present.map(({ name, points, color }) => ({ name, points, color })));
  const fingers = (type: "touchStart" | "touchMove" | "touchEnd", points: readonly Point[]) =>
    session.send("Input.dispatchTouchEvent", { type, touchPoints: points.map(([x, y], id) => ({ x, y, id })) });
  const pose = () => page.evaluate(() => window.__breastrig!.pose());
  await page.goto(base);
  await example(page);
  await hook.ready(page);
  await page.keyboard.press("3");
  await page.keyboard.press("p");
  await tap(page.getByRole("button", { name: "Draw on the full screen" }));
  await expect(page.getByRole("button", { name: "Done" })).toBeVisible();
  await expect(page.getByRole("button", { name: "Scan", exact: false }).first()).toBeHidden();
  await untilStill(page);

  await test.step("a finger draws as long as there is no pen", async () => {
    await fingers("touchStart", [[470, 360]]);
    for (let i = 1; i <= 10; i += 1) await fingers("touchMove", [[470 + 5 * i, 360]]);
    await fingers("touchEnd", []);
    await expect.poll(lines).toHaveLength(1);
  });

  await test.step("light or hard, the pen's line is the same", async () => {
    await stroke(session, [470, 320], [560, 330], () => 0.05);
    await untilStill(page);
    await tap(page.getByRole("button", { name: "Red", exact: true }));
    await stroke(session, [470, 320], [560, 330], (share) => 0.1 + 0.9 * share);
    await expect.poll(lines).toHaveLength(3);
    const [, light, hard] = await lines();
    expect([light!.color, hard!.color]).toEqual(["#101010", "#c53030"]);
    expect(hard!.points).toHaveLength(light!.points.length);
    expect(Math.max(...hard!.points.map((point, i) => distance(point, light!.points[i]!)))).toBeLessThan(0.01);
  });

  await test.step("once a pen was there a finger turns, and draws nothing", async () => {
    const before = await pose();
    await fingers("touchStart", [[470, 400]]);
    for (let i = 1; i <= 8; i += 1) await fingers("touchMove", [[470 + 8 * i, 400]]);
    await fingers("touchEnd", []);
    await untilStill(page);
    await expect.poll(lines).toHaveLength(3);
    expect(distance((await pose()).eye, before.eye)).toBeGreaterThan(0.02);
    await tap(page.getByRole("button", { name: "Front", exact: true }));
    await untilStill(page);
  });

  await test.step("where that is wished for a finger draws again", async () => {
    const wish = page.locator(".canvas-bar").getByRole("button", { name: "Fingers" });
    await tap(wish);
    await fingers("touchStart", [[470, 400]]);
    for (let i = 1; i <= 8; i += 1) await fingers("touchMove", [[470 + 8 * i, 400]]);
    await fingers("touchEnd", []);
    await untilStill(page); // a tap at once after a fast stroke gave no click here
    await expect.poll(lines).toHaveLength(4);
    await tap(page.getByRole("button", { name: "Undo" }).first());
    await expect.poll(lines).toHaveLength(3);
    await tap(wish);
    await expect(wish).toHaveAttribute("aria-pressed", "false");
  });

  await test.step("the hand on the glass neither draws nor turns while the pen draws", async () => {
    const before = await pose();
    await fingers("touchStart", [[600, 600]]);
    await session.send("Input.dispatchMouseEvent", { type: "mousePressed", x: 470, y: 300, button: "left", buttons: 1, clickCount: 1, pointerType: "pen" });
    for (let i = 1; i <= 10; i += 1) {
      await fingers("touchMove", [[600 + 6 * i, 600]]);
      await session.send("Input.dispatchMouseEvent", { type: "mouseMoved", x: 470 + 8 * i, y: 300, button: "left", buttons: 1, pointerType: "pen" });
    }
    await session.send("Input.dispatchMouseEvent", { type: "mouseReleased", x: 550, y: 300, button: "left", buttons: 0, clickCount: 1, pointerType: "pen" });
    await fingers("touchMove", [[700, 640]]);
    await fingers("touchEnd", []);
    await untilStill(page);
    await expect.poll(lines).toHaveLength(4);
    expect(distance((await pose()).eye, before.eye)).toBeLessThan(1e-6);
  });

  await test.step("a line is erased by a touch of the pen, and comes back", async () => {
    await tap(page.getByRole("button", { name: "Erase", exact: true }));
    const at = await hook.project(page, (await lines())[3]!.points[10]!);
    await stroke(session, [at.x, at.y], [at.x, at.y], () => 0.5);
    await expect.poll(lines).toHaveLength(3);
    await tap(page.getByRole("button", { name: "Undo", exact: true }));
    await expect.poll(lines).toHaveLength(4);
  });

  await test.step("Done leads back; where the browser does not give the screen it is the window", async () => {
    expect(await page.evaluate(() => document.fullscreenElement !== null)).toBe(true);
    await tap(page.getByRole("button", { name: "Done" }));
    await expect(page.locator(".view-bar")).toBeVisible();
    await page.keyboard.press("p");
    await expect(page.getByRole("button", { name: "Draw on the full screen" })).toBeVisible();
    await expect.poll(() => page.evaluate(() => document.fullscreenElement)).toBeNull();
    await page.evaluate(() => Object.defineProperty(document.documentElement, "requestFullscreen", { value: undefined }));
    await tap(page.getByRole("button", { name: "Draw on the full screen" }));
    await expect(page.getByRole("button", { name: "Done" })).toBeVisible();
    const box = (await page.locator("canvas.view").boundingBox())!;
    expect([box.x, box.y, box.width, box.height]).toEqual([0, 0, 1024, 768]);
  });

  await test.step("all can be pressed and read, lying and upright, by day and by night", async () => {
    for (const viewport of [{ width: 1024, height: 768 }, { width: 820, height: 1180 }, { width: 1440, height: 900 }]) {
      await page.setViewportSize(viewport);
      expect(await overlaps(page), `${viewport.width}`).toEqual([]);
      expect(await smallTargets(page)).toEqual([]);
      const small = await page.evaluate((least) => [...document.querySelectorAll<HTMLElement>(".canvas-bars button, .canvas-bars input")].filter((each) => each.checkVisibility()).map((each) => [each.textContent, each.offsetWidth, each.offsetHeight] as const).filter(([, width, height]) => width < least || height < least), TARGET_PX);
      expect(small).toEqual([]);
    }
    expect(await seriousFindings(page)).toEqual([]);
    await inTheme(page, "dark");
    expect(await seriousFindings(page, { runOnly: ["color-contrast"] })).toEqual([]);
  });

  await test.step("Escape leads back", async () => {
    await page.keyboard.press("Escape");
    await expect(page.getByRole("button", { name: "Done" })).toBeHidden();
  });
  expect(troubles).toEqual([]);
});
