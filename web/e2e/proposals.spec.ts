// Proposed landmarks: dashed marks where the API says, confirmed on the canvas, in the list and one after the other.
import { expect } from "@playwright/test";
import type { ProposedLandmarks } from "../src/api/types";
import { example, hook, test, untilStill } from "./page";

test("proposals are dashed until they are confirmed, and then picks like any other", async ({ page, base, troubles }) => {
  let answer = (): void => undefined;
  const isPressed = new Promise<void>((done) => (answer = done));
  await page.route(/proposed/, async (route) => {
    const response = await route.fetch();
    if (response.status() === 200) await isPressed;
    await route.fulfill({ response });
  });
  await page.goto(base);
  await example(page);
  await hook.ready(page);
  await page.keyboard.press("2");

  await test.step("what is pressed stays below the pointer when they come", async () => {
    const listTop = () => page.locator(".landmarks").evaluate((list) => (list as HTMLElement).offsetTop);
    await expect(page.getByText("Looking for the landmarks")).toBeVisible();
    const example = page.getByRole("button", { name: "Use the example's landmarks" });
    await example.hover();
    const [before, top] = [await example.boundingBox(), await listTop()];
    await page.mouse.down();
    answer();
    await expect(page.locator("[data-proposed]").first()).toBeAttached();
    expect(await example.boundingBox()).toEqual(before);
    await page.mouse.up();
    expect(await hook.pickCount(page)).toBe(12);
    await page.keyboard.press("z");
    await expect(page.locator(".landmark.is-proposed")).toHaveCount(12);
    expect(await listTop(), "the list begins where it began").toBe(top);
  });
  const check = page.getByRole("button", { name: "Check them one by one" });
  await expect(page.locator("#next")).toHaveText("Confirm the 2 points seen"); // by the example's colours
  const scan = await page.evaluate(() => window.__breastrig!.state().scan!.info);
  const { landmarks } = (await (await page.request.get(base + scan.links.proposed)).json()) as ProposedLandmarks;
  expect(await hook.pickCount(page)).toBe(0);

  await test.step("each mark stands where the API says, with its error", async () => {
    await expect(page.locator("[data-proposed]")).toHaveCount(Object.keys(landmarks).length);
    const canvas = (await page.locator("main canvas.view").boundingBox())!;
    for (const [name, { point }] of Object.entries(landmarks)) {
      const { x, y } = await hook.project(page, point);
      const style = await page.locator(`[data-proposed=${name}]`).evaluate((each) => (each as HTMLElement).style.transform);
      const [left, top] = style.match(/-?[\d.]+(?=px)/g)!.map(Number);
      expect(Math.hypot(left! + canvas.x - x, top! + canvas.y - y), name).toBeLessThan(1);
    }
  });

  await test.step("a click on a proposal confirms it: the pick is the API's point", async () => {
    const { x, y } = await hook.project(page, landmarks.nipple_L!.point);
    await page.mouse.click(x + 3, y - 3);
    expect(await hook.pick(page, "nipple_L")).toEqual(landmarks.nipple_L!.point);
    await expect(page.locator("[data-proposed=nipple_L]")).toHaveCount(0);
    await page.keyboard.press("z");
    expect(await hook.pickCount(page)).toBe(0);
    await expect(page.locator("[data-proposed=nipple_L]")).toHaveCount(1);
  });

  await test.step("in the list, one by one", async () => {
    await page.getByRole("button", { name: /^Confirm the proposed nipple, patient's right/ }).press("Enter");
    expect(await hook.pick(page, "nipple_R")).toEqual(landmarks.nipple_R!.point);
  });

  await test.step("those that colour shows at once; the form's own proposals are not offered so", async () => {
    await page.keyboard.press("z");
    await page.locator("#next").click();
    expect(await hook.pick(page, "nipple_L")).toEqual(landmarks.nipple_L!.point);
    expect(await hook.pickCount(page)).toBe(2);
    await expect(page.locator("#next")).toHaveText("Fit with 2 landmarks");
  });

  await test.step("one after the other, each seen from near; the service keeps them; the others stay open", async () => {
    await check.click();
    const wanted = 5;
    for (let count = await hook.pickCount(page); count < wanted; count += 1) {
      await page.getByRole("button", { name: "Take the proposal" }).click();
      expect(await hook.pickCount(page)).toBe(count + 1);
    }
    await page.keyboard.press("Escape");
    await expect(page.locator("[data-proposed]")).toHaveCount(Object.keys(landmarks).length - wanted);
    await expect(page.locator(".top-bar .saved")).toHaveText("Saved");
    const kept = (await (await page.request.get(base + scan.links.landmarks)).json()) as { landmarks: object };
    expect(Object.keys(kept.landmarks).length).toBe(wanted);
  });

  await test.step("a confirmed one is placed again by a click, and the eye comes near for it", async () => {
    const apart = async (): Promise<number> => {
      const [one, other] = [await hook.project(page, landmarks.nipple_L!.point), await hook.project(page, landmarks.nipple_R!.point)];
      return Math.hypot(one.x - other.x, one.y - other.y);
    };
    await untilStill(page);
    const before = await apart();
    await page.locator(".landmarks [data-landmark=nipple_L] .landmark-name").click();
    await untilStill(page);
    expect(await apart()).toBeGreaterThan(1.5 * before);
    const { x, y } = await hook.project(page, landmarks.nipple_L!.point);
    await page.mouse.click(x - 25, y);
    expect(await hook.pick(page, "nipple_L")).not.toEqual(landmarks.nipple_L!.point);
  });
  expect(troubles).toEqual([]);
});
