// The result in colour: distances are those of distances.bin, under the pointer and in the numbers; scan and model beside
// each other and cut by a line.
import { readFileSync } from "node:fs";
import { expect, type Page } from "@playwright/test";
import type { Fit, Result } from "../src/api/types";
import { distanceWithin, readDistances, SCANNER_MM, summarise } from "../src/fit/distances/distances";
import { formatMm, formatPercent, formatSignedMm } from "../src/ui/units";
import { distance, example, hook, look, more, openDetails, openFiles, test, until, untilFitted, untilStill } from "./page";

/** Shares of strongly blue and strongly orange pixels in a part of the stage (0 to 1 across). */
async function colours(page: Page, from: number, to: number): Promise<{ coloured: number; skin: number }> {
  await untilStill(page);
  const box = (await page.locator("main canvas.view").boundingBox())!;
  const clip = { x: box.x + from * box.width, y: box.y, width: (to - from) * box.width, height: box.height - 140 };
  const shot = (await page.screenshot({ clip })).toString("base64");
  return page.evaluate(async (data) => {
    const image = new Image();
    image.src = `data:image/png;base64,${data}`;
    await image.decode();
    const canvas = document.createElement("canvas");
    [canvas.width, canvas.height] = [image.width, image.height];
    const context = canvas.getContext("2d")!;
    context.drawImage(image, 0, 0);
    const { data: pixels } = context.getImageData(0, 0, image.width, image.height);
    let [coloured, skin] = [0, 0];
    for (let i = 0; i < pixels.length; i += 4) {
      const [r, g, b] = [pixels[i]!, pixels[i + 1]!, pixels[i + 2]!];
      if (b - r > 30 || (r - b > 75 && r - g > 25)) coloured += 1;
      if (r - b > 15 && r - b <= 75) skin += 1;
    }
    return { coloured: (4 * coloured) / pixels.length, skin: (4 * skin) / pixels.length };
  }, shot);
}

test("distances are coloured, read under the pointer, and are the service's", async ({ page, base, troubles }) => {
  await page.goto(base);
  await example(page);
  await hook.ready(page);
  await page.keyboard.press("2");
  await page.getByRole("button", { name: "Use the example's landmarks" }).click();
  await page.getByRole("button", { name: /^Fit with \d+ landmarks$/ }).click();
  await untilFitted(page);
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
    await expect(page.locator(".numbers .verdict")).toHaveText(`Ready to drawLines are one finger wide ±\u00a0${Math.round(result.line_error_mm!)}\u00a0mm. The grey band holds the true line nine times in ten.`);
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
      return { body: shades(0, 0, image.width, image.height - 68), bar: shades(36, image.height - 68 - 420, 20, 320), foot: shades(0, image.height - 60, image.width, 60) };
    }, png.toString("base64"));
    expect(seen.body, "the body").toBeGreaterThan(100);
    expect(seen.bar, "the colours' scale").toBeGreaterThan(20);
    expect(seen.foot, "scale and notice").toBeGreaterThan(5);
  });

  await test.step("side by side: two bodies, the map on the right one only", async () => {
    await look(page, "Beside");
    await untilStill(page);
    expect(await read(0.25, 0.4), "over the scan there is no value").toBeNull();
    expect(await read(0.75, 0.45), "over the model, between the breasts").not.toBeNull();
    await page.mouse.move(5, 5);
    const [left, right] = [await colours(page, 0, 0.5), await colours(page, 0.5, 1)];
    expect(left.skin).toBeGreaterThan(0.05);
    expect(right.skin).toBeLessThan(left.skin / 2);
  });

  await test.step("the line between scan and model is moved by keys", async () => {
    await look(page, "Swipe");
    const line = page.getByRole("slider", { name: "Line between scan and model" });
    await line.focus();
    const half = await hook.picture(page);
    for (let i = 0; i < 20; i += 1) await page.keyboard.press("ArrowRight");
    await expect(line).toHaveValue("0.7");
    expect((await hook.picture(page)).checksum).not.toBe(half.checksum);
    expect(await read(0.6, 0.5)).toBeNull();
    await page.keyboard.press("Home");
    expect(await read(0.5, 0.3)).not.toBeNull();
  });
  expect(troubles).toEqual([]);
});

test("the model's shape is read off sliders; they pose the picture, not the fit", async ({ page, base, troubles }) => {
  await page.emulateMedia({ reducedMotion: "reduce" });
  await page.goto(base);
  await example(page);
  await hook.ready(page);
  await page.keyboard.press("1");
  await page.getByRole("button", { name: "Fit without landmarks" }).click();
  await untilFitted(page);
  await openDetails(page);
  await page.locator("summary", { hasText: "Shape of the model" }).click();
  await page.locator("summary", { hasText: "Left breast" }).click();
  await page.locator("summary", { hasText: "Size of the parts" }).click();
  const fit = (await hook.fit(page))!;
  const result = (await (await page.request.get(`${base}/api/fits/${fit.id}/result.json`)).json()) as Result;
  const forward = page.getByRole("slider", { name: /^Breast stands further forward/ });
  const waist = page.getByRole("slider", { name: /^Waist, width/ });
  expect(Number(await forward.inputValue())).toBeCloseTo(result.parameters.blendshapes.projection_L!, 1);
  expect(Number(await waist.inputValue())).toBeCloseTo(result.parameters.bones.find(({ name }) => name === "lumbar")!.scale[0], 1);
  const sure = (await page.locator(".numbers .verdict").textContent())!;
  const fitted = await hook.picture(page);
  await forward.fill("1.5");
  await waist.fill("1.4");
  const posed = await hook.picture(page);
  expect(posed.checksum).not.toBe(fitted.checksum);
  await expect(page.getByText("Posed by hand")).toBeVisible();
  await expect(page.locator(".numbers .verdict")).toHaveText(sure);
  await page.getByRole("button", { name: "Back to the fitted shape" }).click();
  expect((await hook.picture(page)).checksum).toBe(fitted.checksum);
  expect(troubles).toEqual([]);
});

test("a landmark that is dragged after the fit is fitted again at once, and arrow keys move one along the skin", async ({ page, base, troubles }) => {
  await page.goto(base);
  await example(page);
  await hook.ready(page);
  await page.keyboard.press("2");
  await page.getByRole("button", { name: "Use the example's landmarks" }).click();
  await page.getByRole("button", { name: /^Fit with \d+ landmarks$/ }).click();
  await untilFitted(page);
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
