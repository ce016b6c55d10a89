// The whole way once, as a person goes it: scan in, landmarks by clicks on the body, live fit, numbers, reload.
import { expect, type Page } from "@playwright/test";
import type { EventPage, Result, Vector } from "../src/api/types";
import { formatMm, formatMmWhole, formatPercent, formatSeconds } from "../src/ui/units";
import { addToPlan, distance, hook, openDetails, openFiles, SCAN_FILE, test, trueLandmarks, until, untilFitted, untilStill } from "./page";

const CLOSE_MM = 3;
const HOLE_MM = 15; // below the breasts this scan has holes: beside one, where there is skin

async function lookFromBelow(page: Page): Promise<void> {
  const { x, y, width, height } = (await page.locator("main canvas.view").boundingBox())!;
  await page.mouse.move(x + 0.2 * width, y + 0.6 * height);
  await page.mouse.down();
  await page.mouse.move(x + 0.2 * width, y + 0.6 * height - 60, { steps: 4 });
  await page.mouse.up();
  await untilStill(page);
}

/** Page pixels of the skin that is seen nearest to a place. */
const skinNear = (page: Page, at: { x: number; y: number }, to: Vector): Promise<{ x: number; y: number }> =>
  page.evaluate(
    ([{ x, y }, goal]) => {
      let best = { x, y, off: Infinity };
      for (let away = 0; away <= 96; away += 4) {
        for (let turn = 0; turn < 16; turn += 1) {
          const [px, py] = [x + away * Math.cos((turn * Math.PI) / 8), y + away * Math.sin((turn * Math.PI) / 8)];
          const hit = window.__breastrig!.pickAt(px, py)?.point;
          const off = hit ? Math.hypot(...hit.map((value, axis) => value - goal[axis]!)) : Infinity;
          if (off < best.off) best = { x: px, y: py, off };
        }
        if (best.off < 2) break;
      }
      return best;
    },
    [at, to] as const,
  );

test.use({ contextOptions: { reducedMotion: "no-preference" } }); // with its motion, as most people see it

test("a scan is uploaded, landmarks are clicked, the model settles and the numbers are the service's", async ({ page, base, troubles }) => {
  const truth = trueLandmarks();
  const all = Object.keys(truth);

  await test.step("the file goes in and the body is drawn", async () => {
    await page.goto(base);
    await expect(page.getByText("Drop the patient's scans anywhere on this page")).toBeVisible();
    await page.locator("#scan-file").setInputFiles(SCAN_FILE);
    await hook.ready(page);
    const { colours, isLost } = await hook.picture(page);
    expect(isLost).toBe(false);
    expect(colours, "a lit body has many shades").toBeGreaterThan(100);
    await expect(page.locator(".facts")).toContainText(/\d\d.cm wide, \d\d high, 2\d deep/); // the body's axes: in the file's it is 26
  });

  await test.step("all twelve are placed by clicks on the body, each with its guide", async () => {
    await page.getByRole("button", { name: "Set points myself" }).click();
    await expect(page.locator("[data-proposed]").first()).toBeAttached();
    expect(all).toHaveLength(12);
    for (const name of all) {
      await page.locator(`.landmarks [data-landmark=${name}] .landmark-name`).click();
      await expect(page.locator(".guide .model-picture")).toBeVisible();
      await untilStill(page); // the eye comes near
      let at = await hook.project(page, truth[name]!);
      for (let turns = 0; at.hidden && turns < 6; turns += 1) {
        await lookFromBelow(page); // a fold lies under the breast
        at = await hook.project(page, truth[name]!);
      }
      const near = await skinNear(page, at, truth[name]!);
      await page.mouse.click(near.x, near.y);
      const picked = await hook.pick(page, name);
      expect(picked, `${name} is placed`).not.toBeNull();
      expect(distance(picked!, truth[name]!), `${name}: distance of the pick to the true point, mm`).toBeLessThan(name.startsWith("inframammary") ? HOLE_MM : CLOSE_MM);
    }
  });

  await test.step("a drag turns the view and places nothing", async () => {
    const before = await hook.picture(page);
    const canvas = (await page.locator("main canvas.view").boundingBox())!;
    const [x, y] = [canvas.x + canvas.width / 2, canvas.y + canvas.height / 2];
    await page.mouse.move(x, y);
    await page.mouse.down();
    await page.mouse.move(x + 90, y + 20, { steps: 4 });
    await page.mouse.up();
    expect(await hook.pickCount(page)).toBe(all.length);
    expect((await hook.picture(page)).checksum).not.toBe(before.checksum);
    await page.keyboard.press("f");
  });

  await test.step("undo takes the last one back, redo returns it, and the service keeps them", async () => {
    await page.keyboard.press("z");
    expect(await hook.pick(page, all.at(-1)!)).toBeNull();
    await page.keyboard.press("Shift+Z");
    expect(await hook.pickCount(page)).toBe(all.length);
    await expect(page.locator(".top-bar .saved")).toHaveText("Saved");
    const scan = await page.evaluate(() => window.__breastrig!.state().scan!.info);
    const kept = (await (await page.request.get(base + scan.links.landmarks)).json()) as { landmarks: Record<string, Vector> };
    expect(Object.keys(kept.landmarks).sort()).toEqual([...all].sort());
    expect(distance(kept.landmarks.nipple_L!, truth.nipple_L!)).toBeLessThan(CLOSE_MM);
  });

  await test.step("a drawing of the model is planned", async () => {
    await page.keyboard.press("3");
    await addToPlan(page, /lumpectomy/i);
    await page.keyboard.press("2");
  });

  const before = await hook.picture(page);
  await test.step("the model settles before our eyes", async () => {
    // The page itself notes each iteration that it shows: a look from outside, or at every frame, may miss some.
    await page.evaluate(() => {
      const seen: number[] = [];
      Object.assign(window, { shownIterations: seen });
      const position = document.querySelector(".timeline .position")!;
      const note = (): void => {
        const shown = window.__breastrig!.state().fit?.shown ?? -1;
        if (shown >= 0 && shown !== seen.at(-1)) seen.push(shown);
      };
      new MutationObserver(note).observe(position, { childList: true, characterData: true, subtree: true });
    });
    await openDetails(page); // the iterations
    await page.getByRole("button", { name: /^Fit with \d+ landmarks$/ }).click();
    await untilFitted(page);
    const after = await hook.picture(page);
    expect(after.checksum).not.toBe(before.checksum);
    expect(after.colours).toBeGreaterThan(100);
    expect(after.isLost).toBe(false);
    const seen = await page.evaluate(() => (window as unknown as { shownIterations: number[] }).shownIterations);
    const { iterations } = (await hook.fit(page))!;
    expect(iterations).toBeGreaterThan(3);
    expect(seen, "one after another, and all of them").toEqual(Array.from({ length: iterations }, (_, i) => i));
    const slider = page.locator("#iteration");
    await slider.fill("0");
    const drawn = await hook.picture(page);
    const line = page.locator(".item-details input[type=checkbox]").first();
    await line.evaluate((box: HTMLInputElement) => box.click());
    expect((await hook.picture(page)).checksum, "the drawing lies on the model from the first iteration on").not.toBe(drawn.checksum);
    await line.evaluate((box: HTMLInputElement) => box.click());
    expect((await hook.picture(page)).checksum, "an early iteration looks different").not.toBe(after.checksum);
    await slider.fill((await slider.getAttribute("max"))!);
  });

  const fit = (await hook.fit(page))!;
  await test.step("all iterations arrived", async () => {
    const { events } = (await (await page.request.get(`${base}/api/fits/${fit.id}/events.json`)).json()) as EventPage;
    const iterated = events.filter(({ event }) => event.kind === "iterated");
    expect(iterated.length).toBeGreaterThan(2);
    expect(fit.iterations).toBe(iterated.length);
  });

  await test.step("the numbers are those of result.json", async () => {
    const result = (await (await page.request.get(`${base}/api/fits/${fit.id}/result.json`)).json()) as Result;
    const surface = result.surface_distance_mm;
    const back = result.scan_to_model_mm;
    const numbers = page.locator(".numbers");
    await expect(numbers.locator(".verdict")).toContainText(`wide ±\u00a0${formatMmWhole(await page.evaluate(() => Math.max(...window.__breastrig!.state().drawn.onScan!.plan.shapes.map(({ line_error_mm: mm }) => mm ?? 0))))}\u00a0mm`);
    const block = (title: string) => numbers.locator(".block", { has: page.locator("h3", { hasText: new RegExp(`^${title}$`) }) });
    const mm = (value: number | null): string => `${formatMm(value)} mm`;
    await expect(block("Model to scan").locator("dd")).toHaveText([mm(surface.mean), mm(surface.std), mm(surface.p95), mm(surface.max), `${formatPercent(surface.coverage)} %`]);
    await expect(block("Scan to model").locator("dd")).toHaveText([mm(back.mean), mm(back.std), mm(back.p95), mm(back.max)]);
    await expect(block("Landmarks").locator("dd")).toHaveText([mm(result.landmark_distance_mm.mean), mm(result.landmark_distance_mm.max)]);
    await expect(block("Run").locator("dd").first()).toHaveText(`${formatSeconds(result.timing_s.solve)} s`);
    await numbers.getByText("Each landmark").click();
    for (const [name, value] of Object.entries(result.landmark_distance_mm.each)) {
      const radius = formatMmWhole(result.landmark_uncertainty_mm![name]!);
      await expect(numbers.locator(`[data-landmark=${name}] dd`)).toHaveText(new RegExp(`^${formatMm(value)}\\s*±\\s${radius} mm$`));
    }
  });

  await test.step("at rest nothing is drawn", async () => {
    await page.mouse.move(5, 5);
    await until(page, () => window.__breastrig?.state().fit?.distances);
    await untilStill(page);
    const drawn = await page.evaluate(() => window.__breastrig!.frames());
    await page.waitForTimeout(1000);
    expect(await page.evaluate(() => window.__breastrig!.frames())).toBe(drawn);
  });

  await test.step("the slider shows earlier iterations again", async () => {
    const end = await hook.picture(page);
    await page.locator("#iteration").fill("0");
    await expect(page.locator(".timeline .position")).toHaveText(/^0 \//);
    expect((await hook.picture(page)).checksum).not.toBe(end.checksum);
  });

  await test.step("every offered file can be had", async () => {
    await expect(page.locator(".stage canvas.view").first()).toBeVisible();
    await openFiles(page);
    await expect(page.locator(".paper img").first(), "the printed pages stand in place of the body").toBeVisible();
    const links = await page.locator(".files a").evaluateAll((all) => all.map((each) => (each as HTMLAnchorElement).href));
    expect(links.length).toBe(5);
    for (const link of links) expect((await page.request.get(link)).status(), link).toBe(200);
  });

  await test.step("after a reload the same is shown", async () => {
    await page.reload();
    await hook.ready(page);
    await untilFitted(page);
    expect(await hook.fit(page)).toEqual(fit);
    expect(await hook.pickCount(page)).toBe(Object.keys(truth).length);
  });

  expect(troubles).toEqual([]);
});
