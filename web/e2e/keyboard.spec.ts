// The whole main job by keys alone: no mouse event is ever sent.
import { expect, type Page } from "@playwright/test";
import { distance, hook, openDetails, test, trueLandmarks, until, untilFitted, untilStill } from "./page";

/** Tabs until something with this name has the focus; says how many presses it took. */
async function tabTo(page: Page, name: RegExp, most = 60): Promise<number> {
  for (let pressed = 1; pressed <= most; pressed += 1) {
    await page.keyboard.press("Tab");
    if (name.test(await focusName(page))) return pressed;
  }
  throw new Error(`nothing named ${name} within ${most} tabs`);
}

const focusName = (page: Page): Promise<string> =>
  page.evaluate(() => {
    const { activeElement: focus } = document;
    const label = focus?.closest("label") ?? (focus?.id ? document.querySelector(`label[for="${focus.id}"]`) : null);
    return (focus?.getAttribute("aria-label") ?? label?.textContent ?? focus?.textContent ?? "").trim();
  });

/** Every stop of the Tab key, in its order: what it is called, where it stands in the document, whether one sees it. */
async function tabOrder(page: Page): Promise<{ name: string; place: number; isSeen: boolean }[]> {
  // From the top: where the focus was last, the browser would go on from there.
  await page.evaluate(() => {
    document.body.tabIndex = -1;
    document.body.focus();
    document.body.removeAttribute("tabindex");
  });
  const stops = [];
  for (let i = 0; i < 80; i += 1) {
    await page.keyboard.press("Tab");
    const stop = await page.evaluate(() => {
      const focus = document.activeElement;
      if (!focus || focus === document.body) return null;
      const shown = focus.matches(".visually-hidden") ? focus.closest("label")! : focus; // a file button shows its label
      const box = shown.getBoundingClientRect();
      const style = getComputedStyle(shown);
      const thumb = getComputedStyle(shown, "::-webkit-slider-thumb");
      const hasRing = [style, thumb].some(({ outlineStyle, outlineWidth }) => outlineStyle !== "none" && parseFloat(outlineWidth) >= 2);
      const isOnScreen = box.width > 0 && box.bottom > 0 && box.right > 0 && box.top < innerHeight && box.left < innerWidth;
      return { name: focus.outerHTML.slice(0, 100), place: [...document.querySelectorAll("*")].indexOf(focus), isSeen: hasRing && isOnScreen };
    });
    if (stop === null) break;
    stops.push(stop);
  }
  return stops;
}

test("from page load to the fitted result without a mouse, and the live region says how it goes", async ({ page, base, troubles }) => {
  const truth = trueLandmarks();
  const status = page.locator("p.visually-hidden[role=status]");
  await page.emulateMedia({ reducedMotion: "reduce" });
  await page.goto(base);
  await expect(page.getByRole("button", { name: "Try the example" })).toBeVisible();
  await expect(status).toHaveAttribute("aria-live", "polite");

  await test.step("the example is reached by Tab", async () => {
    await tabTo(page, /^Try the example/);
    await page.keyboard.press("Enter");
    await tabTo(page, /standing$/i);
    await page.keyboard.press("Enter");
    await hook.ready(page);
  });

  await test.step("a landmark is placed by the cross on the body", async () => {
    await page.keyboard.press("2");
    await page.keyboard.press("n");
    const name = (await page.evaluate(() => window.__breastrig!.state().active))!;
    expect(await page.evaluate(() => document.activeElement?.matches("canvas.view")), "the view has the focus").toBe(true);
    await untilStill(page);
    const goal = await hook.project(page, truth[name]!);
    const cross = async () => {
      const { x, y, width, height } = (await page.locator(".crosshair").boundingBox())!;
      return { x: x + width / 2, y: y + height / 2 };
    };
    await expect(page.locator(".crosshair")).toBeVisible();
    await until(page, () => window.__breastrig!.state().proposals?.state === "found"); // said aloud when they come
    for (const [axis, back, forth] of [["x", "ArrowLeft", "ArrowRight"], ["y", "ArrowUp", "ArrowDown"]] as const) {
      for (let i = 0; i < 80; i += 1) {
        const away = goal[axis] - (await cross())[axis];
        if (Math.abs(away) <= 3) break;
        await page.keyboard.press(`${Math.abs(away) > 30 ? "Shift+" : ""}${away < 0 ? back : forth}`);
      }
    }
    await expect(page.locator(".loupe")).toBeVisible();
    await page.keyboard.press("Enter");
    expect(distance((await hook.pick(page, name))!, truth[name]!), "mm off").toBeLessThan(6);
    await expect(status).toHaveText(/^Placed: .* Next: /);
    const next = await page.evaluate(() => window.__breastrig!.state().active);
    expect(next).not.toBe(name);
    await page.keyboard.press("z");
    await page.keyboard.press("Shift+Z");
    await page.keyboard.press("Escape");
    expect(await hook.pickCount(page)).toBe(1);
  });

  await test.step("the others are proposals, confirmed by a key press each", async () => {
    await expect(page.locator("[data-proposed]").first()).toBeAttached();
    for (const count of [2, 3, 4]) {
      await tabTo(page, /^Confirm the proposed /);
      await page.keyboard.press("Enter");
      await expect.poll(() => hook.pickCount(page)).toBe(count);
      await expect(status).toHaveText(/^Confirmed: /);
    }
  });

  await test.step("every stop of the Tab key is in the document's order and is seen", async () => {
    const stops = await tabOrder(page);
    expect(stops.length).toBeGreaterThan(20);
    expect(stops.filter(({ isSeen }) => !isSeen)).toEqual([]);
    expect(stops.map(({ place }) => place)).toEqual(stops.map(({ place }) => place).sort((a, b) => a - b));
  });

  await test.step("the fit is started, followed and looked at", async () => {
    await page.keyboard.press("1");
    await tabTo(page, /^Fit with \d+ landmarks$/);
    await page.keyboard.press("Enter");
    await untilFitted(page);
    const off = await page.evaluate(() => window.__breastrig!.state().fit!.result!.line_error_mm!);
    await expect(status).toHaveText(new RegExp(`^The fit is done: mean distance [\\d.]+ millimetres\\. Ready to draw\\. 3 landmarks were only agreed to where they were proposed; .* Lines on the breasts: one finger wide, ±\u00a0${Math.round(off)}\u00a0mm\\.$`));
    const front = await hook.picture(page);
    await tabTo(page, /^3D view/);
    await page.keyboard.press("Shift+ArrowRight");
    const turned = await hook.picture(page);
    expect(turned.checksum).not.toBe(front.checksum);
    await page.keyboard.press("+");
    expect((await hook.picture(page)).checksum).not.toBe(turned.checksum);
    const drawn = await page.evaluate(() => window.__breastrig!.frames());
    await page.keyboard.press("f");
    await untilStill(page);
    const jump = (await page.evaluate(() => window.__breastrig!.frames())) - drawn;
    expect(jump, "pictures on the way to the front, for somebody who asked for less motion").toBeLessThan(4);
    const moving = () => page.evaluate(() => [...document.querySelectorAll("*")].map((each) => getComputedStyle(each)).filter(({ animationName, transitionDuration }) => animationName !== "none" || transitionDuration !== "0s").length);
    expect(await moving(), "nothing of the page moves either").toBe(0);
    await page.emulateMedia({ reducedMotion: "no-preference" });
    expect(await moving(), "as it does for others").toBeGreaterThan(0);
    await page.emulateMedia({ reducedMotion: "reduce" });
    await openDetails(page);
    await tabTo(page, /^Iteration$/);
    await page.keyboard.press("Home");
    await expect(page.locator(".timeline .position")).toHaveText(/^0 \//);
  });
  expect(troubles).toEqual([]);
});
