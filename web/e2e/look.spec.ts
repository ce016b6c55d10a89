// What is looked at on the stage, as only a browser shows it: the even mixture of scan and model, the mirrored breast, the lasso,
// and the measure that is pointed at in the table.
import { expect, type Page } from "@playwright/test";
import { overlaps, seriousFindings, smallTargets } from "./audit";
import { fittedExample, hook, look, openDetails, test, trueLandmarks, until, untilStill } from "./page";
import { inTheme } from "./states";

/** Red over blue of the pixels around page places; skin-coloured clay has more red than a grey scan. */
async function warmth(page: Page, places: readonly { x: number; y: number }[]): Promise<number[]> {
  const shot = [...(await page.screenshot())];
  return page.evaluate(
    async ([bytes, at]) => {
      const image = await createImageBitmap(new Blob([new Uint8Array(bytes)]));
      const canvas = new OffscreenCanvas(image.width, image.height);
      const pen = canvas.getContext("2d")!;
      pen.drawImage(image, 0, 0);
      const scale = image.width / innerWidth;
      return at.map(({ x, y }) => {
        const [red, , blue] = pen.getImageData(Math.round(x * scale), Math.round(y * scale), 1, 1).data;
        return red! / Math.max(1, blue!);
      });
    },
    [shot, places] as const,
  );
}

const GREY = 0.915; // of the scan beside the model: --view-scan by day

const spread = (values: readonly number[]): number => {
  const sorted = [...values].sort((a, b) => a - b);
  return sorted[Math.floor(0.95 * sorted.length)]! - sorted[Math.floor(0.05 * sorted.length)]!;
};

test("mixture, mirror, lasso and measures", async ({ page, base, troubles }) => {
  await fittedExample(page, base, { step: "body" });
  await until(page, () => window.__breastrig?.state().fit?.distances);
  const truth = trueLandmarks();
  const places: { x: number; y: number }[] = [];

  await test.step("each pixel of the body is one and the same share of scan and model", async () => {
    await look(page, "Both");
    await openDetails(page);
    await page.locator(".timeline input[type=range]").fill("2"); // early, when the model is some millimetres off, here before and there behind
    await page.keyboard.press("f");
    await untilStill(page);
    // A grid over chest, breasts and belly.
    const [top, low] = [await hook.project(page, truth.suprasternal_notch!), await hook.project(page, truth.umbilicus!)];
    const half = Math.abs((await hook.project(page, truth.nipple_L!)).x - (await hook.project(page, truth.nipple_R!)).x) / 2;
    for (let i = 0; i < 14; i += 1) for (let k = 0; k < 14; k += 1) places.push({ x: top.x + half * (i / 6.5 - 1), y: top.y + 10 + (low.y - top.y - 20) * (k / 13) });
    const both = await warmth(page, places);
    await look(page, "Model");
    await untilStill(page);
    const model = await warmth(page, places);
    const median = (values: readonly number[]): number => [...values].sort((a, b) => a - b)[Math.floor(values.length / 2)]!;
    expect(median(model) - median(both), "some of it is the grey scan").toBeGreaterThan(0.03);
    expect(spread(both), "in patches it is the difference of the mixture and grey; the light alone makes half of that").toBeLessThan(0.7 * (median(both) - GREY));
    await page.locator(".timeline input[type=range]").press("End");
  });

  await test.step("the left breast on the right one", async () => {
    await look(page, "Skin");
    await untilStill(page);
    const before = (await hook.picture(page)).checksum;
    await look(page, "Left on right");
    await expect(page.getByText(/^Differs by \d+\.\d mm/)).toBeVisible();
    expect((await hook.picture(page)).checksum).not.toBe(before);
    for (const viewport of [{ width: 1024, height: 768 }, { width: 1280, height: 720 }]) {
      await page.setViewportSize(viewport);
      expect(await overlaps(page)).toEqual([]);
      expect(await smallTargets(page)).toEqual([]);
    }
    expect(await seriousFindings(page)).toEqual([]);
    await look(page, "Left on right");
    await expect(page.getByText(/^Differs by/)).toBeHidden();
  });

  await test.step("the lasso cuts an arm away, Z brings it back, and a fit from before says so", async () => {
    await openDetails(page);
    await page.getByRole("button", { name: "Lasso" }).click();
    await untilStill(page);
    const arm = await hook.project(page, truth.acromion_R!);
    const at = { x: arm.x - 20, y: arm.y + 60 };
    const pick = () => page.evaluate(([x, y]) => window.__breastrig!.pickAt(x, y)?.face ?? null, [at.x, at.y] as const);
    const face = await pick();
    expect(face).not.toBeNull();
    await page.mouse.move(at.x - 60, at.y - 60);
    await page.mouse.down();
    for (const [x, y] of [[30, -60], [30, 200], [-150, 200], [-150, -60]] as const) await page.mouse.move(at.x + x, at.y + y, { steps: 6 });
    await page.mouse.up();
    await expect.poll(pick).toBeNull();
    await expect(page.getByText("until you bring it back", { exact: false })).toHaveCount(0); // the lasso is still in the hand
    await page.keyboard.press("z");
    await expect.poll(pick).toBe(face);
    await page.locator("canvas.view").focus();
    await page.keyboard.press("ArrowUp"); // there is the cross, in the middle
    const box = (await page.locator("canvas.view").boundingBox())!;
    const cross: [number, number] = [box.x + box.width / 2, box.y + box.height / 2];
    for (const corner of [[-90, -60], [30, -60], [30, 200], [-150, 200]] as const) {
      const to = [Math.round((at.x + corner[0] - cross[0]) / 6), Math.round((at.y + corner[1] - cross[1]) / 6)] as const;
      for (const [axis, keys] of [[0, ["ArrowLeft", "ArrowRight"]], [1, ["ArrowUp", "ArrowDown"]]] as const) {
        for (let i = 0; i < Math.abs(to[axis]); i += 1) await page.keyboard.press(keys[to[axis] > 0 ? 1 : 0]);
        cross[axis] += 6 * to[axis];
      }
      await page.keyboard.press("Enter");
    }
    await page.keyboard.press("Enter");
    await expect.poll(pick).toBeNull();
    await page.keyboard.press("Escape");
    await until(page, () => window.__breastrig?.state().scan?.cuts);
    await page.evaluate(() => sessionStorage.clear()); // the service keeps it
    await page.reload();
    await hook.ready(page);
    await page.keyboard.press("1");
    const old = page.getByText("Since this fit, parts of the scan were cut away or brought back.");
    await expect(old).toBeVisible();
    await openDetails(page);
    await expect(page.getByText("kept with the scan until you bring it back", { exact: false })).toBeVisible();
    const back = page.getByRole("button", { name: "Bring cut 1 back" });
    await untilStill(page);
    const without = (await hook.picture(page)).checksum;
    await back.focus(); // it is seen where it was
    await expect.poll(async () => (await hook.picture(page)).checksum).not.toBe(without);
    await back.press("Enter");
    await expect(page.getByRole("button", { name: "Lasso" })).toBeFocused();
    await expect(old).toBeHidden();
    expect(await seriousFindings(page)).toEqual([]);
  });

  await test.step("a measure that is pointed at runs over the body, beside its table", async () => {
    await page.keyboard.press("4");
    await page.locator("#measures").click();
    const tape = page.locator("[data-measure=notch_nipple][data-kind='along the skin']");
    await expect(tape).toBeVisible();
    const head = await page.locator(".measures-scroll").evaluate(async (scroll: HTMLElement) => {
      scroll.style.maxHeight = "200px";
      scroll.scrollTop = 60; // rows go below the head, which hides them wholly
      await new Promise(requestAnimationFrame);
      const cells = [...scroll.querySelectorAll("thead th")].map((cell) => ({ cell, box: cell.getBoundingClientRect() }));
      const answer = {
        scrolled: scroll.scrollTop,
        colours: cells.map(({ cell }) => getComputedStyle(cell).backgroundColor),
        hidden: cells.filter(({ cell, box }) => !cell.contains(document.elementFromPoint(box.x + box.width / 2, box.y + box.height / 2))).length,
        gap: Math.max(...cells.map(({ box }) => box.top)) - Math.min(...cells.map(({ box }) => box.bottom)),
      };
      scroll.style.maxHeight = "";
      scroll.scrollTop = 0;
      return answer;
    });
    expect(head).toMatchObject({ scrolled: 60, hidden: 0 });
    expect(head.colours.filter((colour) => !colour.startsWith("rgb(")), "a head that numbers show through").toEqual([]);
    expect(head.gap, "between its rows").toBeLessThan(0.5);
    const lengths = (await tape.locator("td").allTextContents()).slice(0, 2);
    await page.locator("#measures-title").hover();
    await expect(page.locator(".tape-label")).toHaveCount(0);
    await tape.hover();
    await expect(page.locator(".tape-label")).toHaveText(lengths.map((length) => `${length}\u00a0mm`));
    const dialog = (await page.getByRole("dialog").boundingBox())!;
    for (const name of ["suprasternal_notch", "nipple_L", "nipple_R"]) {
      const { x } = await hook.project(page, truth[name]!);
      expect(x, "the table lies beside the body").toBeLessThan(dialog.x);
    }
    await page.locator("[data-measure=nipple_nipple][data-kind=straight] .measure-name").focus();
    await page.locator("#measures-title").hover();
    expect(await seriousFindings(page)).toEqual([]);
    await inTheme(page, "dark");
    expect(await seriousFindings(page, { runOnly: ["color-contrast"] })).toEqual([]);
    await page.keyboard.press("Escape");
    await expect(page.locator(".tape-label")).toHaveCount(0);
  });

  await test.step("a template is saved under the service's name, and why there is no guide is said", async () => {
    const named = { "Content-Disposition": "attachment; filename=K7M-4QX_standing_template.pdf" };
    await page.route("**/template.pdf", (route) => route.fulfill({ contentType: "application/pdf", headers: named, body: "%PDF" }));
    const saved = page.waitForEvent("download");
    await page.locator("#of-plan-template").click();
    expect((await saved).suggestedFilename()).toBe("K7M-4QX_standing_template.pdf");
    const detail = "No line is on the patient's left side alone; a guide shows the lines of one side.";
    await page.route("**/guide.stl?side=L", (route) => route.fulfill({ status: 422, contentType: "application/problem+json", body: JSON.stringify({ title: "Unprocessable", status: 422, detail }) }));
    await page.getByText("Files for programs").click();
    await page.locator("#of-plan-left").click();
    await expect(page.getByText(detail)).toBeVisible();
  });
  troubles.splice(0, troubles.length, ...troubles.filter((each) => !each.includes("422")));
  expect(troubles).toEqual([]);
});
