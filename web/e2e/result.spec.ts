// The result in colour: distances are those of distances.bin, under the pointer and in the numbers.
import { readFileSync } from "node:fs";
import { expect } from "@playwright/test";
import type { Fit, Result } from "../src/api/types";
import { distanceWithin, readDistances, SCANNER_MM, summarise } from "../src/fit/distances/distances";
import { formatMm, formatPercent, formatSignedMm } from "../src/ui/units";
import { distance, fittedExample, hook, look, more, openFiles, test, until, untilFitted, untilStill } from "./page";

test("distances are coloured, read under the pointer, and are the service's", async ({ page, base, troubles }) => {
  await fittedExample(page, base, { step: "body" });
  const { id } = (await hook.fit(page))!;
  const result = (await (await page.request.get(`${base}/api/fits/${id}/result.json`)).json()) as Result;
  const file = await (await page.request.get(`${base}/api/fits/${id}/distances.bin`)).body();
  const distances = readDistances(file.buffer.slice(file.byteOffset, file.byteOffset + file.length) as ArrayBuffer);

  await test.step("the file's absolute values are those of result.json", async () => {
    const known = [...distances].filter((value) => !Number.isNaN(value)).map(Math.abs);
    expect(known.reduce((sum, value) => sum + value, 0) / known.length).toBeCloseTo(result.surface_distance_mm.mean!, 3);
  });

  await test.step("first stands what the fit is good for; distances to the skin are folded away, with that of the model alone", async () => {
    const alone = result.model_alone!.surface_distance_mm.mean!;
    expect(result.surface_distance_mm.mean!).toBeLessThan(0.5 * alone);
    await expect(page.locator(".numbers .verdict")).toHaveText(`Ready to drawLines on the breasts are one finger wide ±\u00a0${Math.round(result.line_error_mm!)}\u00a0mm. The grey band holds the true line nine times in ten.`);
    await expect(page.locator(".stage .sureness")).toContainText(`one finger wide±\u00a0${Math.round(result.line_error_mm!)}\u00a0mm`);
    await expect(page.locator(".numbers .block").first()).toBeHidden();
    await page.locator(".numbers .solver summary").click();
    await expect(page.locator(".numbers .block", { has: page.locator("h3", { hasText: "The model alone" }) })).toContainText(formatMm(alone));
  });

  await test.step("the numbers panel summarises it", async () => {
    const { meanMm, within, beyond } = summarise(distances)!;
    const block = page.locator(".numbers .block", { has: page.locator("h3", { hasText: "Signed distances" }) });
    await expect(block.locator("dd")).toHaveText([`${formatSignedMm(meanMm)} mm`, `${formatPercent(within)} %`, `${formatPercent(beyond)} %`]);
  });

  await test.step("the map shows with its colour bar; a key takes it away and brings it back", async () => {
    const plain = await hook.picture(page);
    await look(page, "Distances");
    await expect(page.locator(".colour-bar")).toBeVisible();
    expect((await hook.picture(page)).checksum).not.toBe(plain.checksum);
    await page.keyboard.press("d");
    await expect(page.locator(".colour-bar")).toBeHidden();
    await page.keyboard.press("d");
    await expect(page.locator(".colour-bar")).toBeVisible();
  });

  const read = async (across: number, down: number): Promise<number | null> => {
    const box = (await page.locator("main canvas.view").boundingBox())!;
    const [x, y] = [box.x + across * box.width, box.y + down * box.height];
    await page.mouse.move(x, y);
    const hit = await page.evaluate(([left, top]) => window.__breastrig!.surfaceAt(left!, top!), [x, y]);
    if (!hit) return null;
    const mm = distanceWithin(distances, hit.corners, hit.weights);
    await expect(page.locator(".hover-value")).toBeVisible();
    const words = mm === null ? "no scan here" : `${formatSignedMm(mm)} mm`;
    await expect(page.locator(".hover-value")).toContainText(words);
    if (mm !== null && Math.abs(mm) <= SCANNER_MM) await expect(page.locator(".hover-value")).toContainText("within scanner error");
    return mm;
  };

  await test.step("under the pointer stands the value of the file", async () => {
    await untilStill(page);
    const values = [];
    for (const [across, down] of [[0.5, 0.3], [0.4, 0.5], [0.6, 0.5], [0.5, 0.7], [0.45, 0.6]] as const) values.push(await read(across, down));
    expect(values.filter((mm) => mm !== null).length, "places with a value").toBeGreaterThan(2);
    await page.mouse.move(5, 5);
    await expect(page.locator(".hover-value")).toBeHidden();
  });

  await test.step("what can be taken away: every file, the distances as a table, the picture at twice the size", async () => {
    await openFiles(page);
    const links = await page.locator(".files a").evaluateAll((all) => all.map((each) => (each as HTMLAnchorElement).href));
    expect(links.map((link) => link.split("/").at(-1))).toEqual(["report.pdf", "fitted.glb", "fitted.ply", "plan.json", "result.json"]);
    const [table] = await Promise.all([page.waitForEvent("download"), page.getByRole("button", { name: /^distances\.csv/ }).click()]);
    const rows = readFileSync(await table.path(), "utf8").trim().split("\r\n");
    expect(rows.length).toBe(1 + distances.length);
    const some = distances.findIndex((value) => !Number.isNaN(value));
    expect(rows[1 + some]).toBe(`${some},${distances[some]!.toFixed(3)}`);

    await page.keyboard.press("1");
    const [picture] = await Promise.all([page.waitForEvent("download"), more(page, "Picture of this view")]);
    await expect(page.getByRole("banner").getByTitle("The patient's code")).toHaveText(/^[A-Z0-9]{3}-[A-Z0-9]{3}$/);
    expect(picture.suggestedFilename()).toMatch(/^[A-Z0-9]{3}-[A-Z0-9]{3}_standing_\d{4}-\d{2}-\d{2}_view\.png$/);
    const png = readFileSync(await picture.path());
    const stage = (await page.locator(".stage").boundingBox())!;
    expect(png.readUInt32BE(16)).toBe(2 * stage.width);
    expect(png.readUInt32BE(20)).toBeGreaterThan(2 * stage.height);
    expect(png.includes("tIME"), "no date in it").toBe(false);
    const seen = await page.evaluate(async (data) => {
      const image = new Image();
      image.src = `data:image/png;base64,${data}`;
      await image.decode();
      const pen = new OffscreenCanvas(image.width, image.height).getContext("2d")!;
      pen.drawImage(image, 0, 0);
      const shades = (x: number, y: number, width: number, height: number): number => new Set(new Uint32Array(pen.getImageData(x, y, width, height).data.buffer)).size;
      return { body: shades(0, 0, image.width, image.height - 68), bar: shades(36, image.height - 68 - 420, 20, 320), foot: shades(0, image.height - 60, image.width, 60), fingers: shades(32, 28, 40, 40), width: shades(84, 32, 200, 32) };
    }, png.toString("base64"));
    expect(seen.body, "the body").toBeGreaterThan(100);
    expect(seen.bar, "the colours' scale").toBeGreaterThan(20);
    expect(seen.fingers, "the mark of how wide lines are").toBeGreaterThan(1);
    expect(seen.width, "and its millimetres").toBeGreaterThan(5);
    expect(seen.foot, "scale and notice").toBeGreaterThan(5);
  });
  expect(troubles).toEqual([]);
});

test("a landmark that is dragged after the fit is fitted again at once, and arrow keys move one along the skin", async ({ page, base, troubles }) => {
  await fittedExample(page, base, { step: "points" });
  await untilStill(page);
  const first = (await hook.fit(page))!;
  const before = (await hook.pick(page, "umbilicus"))!;
  const at = await hook.project(page, before);
  await page.mouse.move(at.x, at.y);
  await page.mouse.down();
  const before3d = await page.evaluate(() => window.__breastrig!.picture().checksum);
  await page.mouse.move(at.x + 12, at.y + 8, { steps: 3 });
  const wanted = await page.evaluate(([x, y]) => window.__breastrig!.pickAt(x!, y!)!.point, [at.x + 12, at.y + 8]);
  // The model follows while the mark is held, by the service's answers for where it is; the fit waits for its end.
  await until(page, () => window.__breastrig!.state().followed !== null);
  expect((await page.evaluate(() => window.__breastrig!.state().fit!.id)), "no fit was asked for").toBe(first.id);
  expect(await page.evaluate(() => window.__breastrig!.picture().checksum)).not.toBe(before3d);
  const asked = page.waitForRequest((request) => request.url().endsWith("/moved"));
  await page.mouse.move(at.x + 13, at.y + 8);
  await asked;
  await page.mouse.move(at.x + 12, at.y + 8);
  await page.mouse.up();
  await until(page, (id) => window.__breastrig!.state().fit!.id !== id, first.id);
  expect(await page.evaluate(() => window.__breastrig!.state().followed)).toBeNull();
  expect(distance((await hook.pick(page, "umbilicus"))!, wanted)).toBeLessThan(0.01);
  await untilFitted(page);
  const second = (await hook.fit(page))!;
  const result = (await (await page.request.get(`${base}/api/fits/${second.id}/result.json`)).json()) as Result;
  const picked = result.landmarks_picked.umbilicus!; // in the scan's unit, metres
  expect(picked.map((value) => 1000 * value)).toEqual(wanted.map((value) => expect.closeTo(value, 0)));
  const { start_from } = (await (await page.request.get(`${base}/api/fits/${second.id}`)).json()) as Fit;
  expect(start_from, "as whoever begins with these landmarks would get it").toBeNull();

  await page.keyboard.press("2");
  await page.locator(".landmarks [data-landmark=umbilicus] .landmark-name").click();
  await page.locator("main canvas.view").focus();
  const start = (await hook.pick(page, "umbilicus"))!;
  await page.keyboard.press("ArrowRight");
  const one = (await hook.pick(page, "umbilicus"))!;
  await page.keyboard.press("Shift+ArrowRight");
  const six = (await hook.pick(page, "umbilicus"))!;
  const moved = distance(start, one);
  expect(moved).toBeGreaterThan(0.2);
  expect(moved).toBeLessThan(3);
  expect(distance(start, six)).toBeGreaterThan(3 * moved);
  expect(await page.evaluate(() => window.__breastrig!.state().active)).toBe("umbilicus");
  expect(troubles).toEqual([]);
});
