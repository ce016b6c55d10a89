// Marks of the skin: placed and named on one scan, looked for on the other one where its fit expects them, kept with both.
import { execFileSync } from "node:child_process";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { expect } from "@playwright/test";
import type { LandmarkFile, Scan } from "../src/api/types";
import { distance, fittedExample, hook, test, thumb, untilFitted, untilStill } from "./page";
import { findPython, helper } from "./service";

test("a mark is placed and named on one scan and found again on the other", async ({ page, base, troubles }) => {
  const [standing, supine] = await fittedExample(page, base, { stances: ["standing", "supine"], step: "points" });
  const marks = async (made: typeof standing): Promise<LandmarkFile["marks"]> => ((await (await page.request.get(base + made!.scan.links.landmarks!)).json()) as LandmarkFile).marks;
  const list = page.getByRole("region", { name: "Marks on the skin" });
  const guide = page.locator(".guide");

  await list.getByRole("button", { name: "Add a mark" }).click();
  await expect(guide).toContainText("mark 1");
  await expect(guide.locator("canvas"), "no picture of the model shows it").toBeHidden();
  await untilStill(page);
  const notch = await hook.project(page, (await hook.pick(page, "mid_sternum"))!);
  await page.mouse.click(notch.x, notch.y + 40);
  await expect(guide).toBeHidden();
  const field = list.getByLabel("Name of the mark mark 1");
  await field.fill("umbilicus");
  await field.press("Enter");
  await expect(page.getByText("is a landmark's name")).toBeVisible();
  await expect(field).toHaveValue("mark 1");
  await field.fill("mole");
  await field.press("Enter");
  await expect(list.locator("[data-mark=mole]")).toHaveClass(/is-placed/);
  await expect.poll(async () => Object.keys((await marks(standing)) ?? {})).toEqual(["mole"]);
  await page.locator("#next").click(); // the fit knows nothing of it yet
  await untilFitted(page);
  expect(Object.keys((await page.evaluate(() => window.__breastrig!.state().fit!.result!.marks)) ?? {})).toEqual(["mole"]);

  await thumb(page, "supine").click();
  await thumb(page, "supine").click(); // shown, then worked on
  await page.keyboard.press("2");
  const row = list.locator("[data-mark=mole]");
  await expect(row).not.toHaveClass(/is-placed/);
  await expect(row.locator(".mark-name"), "it is one name").not.toBeEditable();
  await row.getByRole("button", { name: /mole/ }).first().click();
  await expect(guide).toContainText("The dashed sign is where it is expected");
  await untilStill(page);
  const expected = (await page.evaluate(() => window.__breastrig!.state().beside["mark:mole"]!));
  await expect(page.locator(".pin.is-proposed[data-proposed='mark:mole'] .mark")).toBeVisible();
  const at = (await hook.project(page, expected));
  await page.mouse.click(at.x + 3, at.y);
  await expect(row).toHaveClass(/is-placed/);
  expect(distance((await hook.pick(page, "mark:mole"))!, expected), "mm").toBeLessThan(20);
  await expect.poll(async () => Object.keys((await marks(supine)) ?? {})).toEqual(["mole"]);
  expect(Object.keys((await marks(standing)) ?? {})).toEqual(["mole"]);

  await page.keyboard.press("Control+z");
  await expect(row).not.toHaveClass(/is-placed/);
  await expect.poll(() => marks(supine)).toBeUndefined();

  // a length that was measured on the patient: two clicks, here a landmark and a click, and a number
  await page.keyboard.press("1");
  await page.locator("#details > summary").click();
  const size = page.getByRole("region", { name: "True size" });
  await size.getByRole("button", { name: "Click both ends" }).click();
  await expect(size).toContainText("Click the first end on the scan.");
  const [before, nipple] = [(await hook.pick(page, "mid_sternum"))!, (await hook.pick(page, "nipple_L"))!];
  for (const [end, says] of [[before, "Click the other end."], [nipple, "In the scan it is"]] as const) {
    await untilStill(page);
    const { x, y } = await hook.project(page, end);
    await page.mouse.click(x, y);
    await expect(size).toContainText(says);
  }
  await size.getByLabel("From").selectOption("mid_sternum");
  await size.getByLabel("On the patient").fill("2,5");
  await size.getByLabel("On the patient").press("Enter");
  await size.getByRole("button", { name: "Apply" }).click();
  await expect(size.getByRole("alert")).toContainText(/^From middle of the breastbone to another it is \d+ mm in the scan, but 25 mm were given/);
  await size.getByLabel("On the patient").fill((1.05 * distance(before, nipple) / 10).toFixed(2));
  await size.getByLabel("On the patient").press("Tab");
  await expect(size.getByLabel("On the patient"), "it stays").not.toHaveValue("");
  await expect(size.getByRole("button", { name: "Apply" })).toBeFocused();
  await page.keyboard.press("Enter");
  await expect(size).toContainText(/Scaled by 1\.0[45]\d: .+ to another is/);
  const factor = await page.evaluate(() => window.__breastrig!.state().scan!.info.scale!.factor);
  expect(distance((await hook.pick(page, "mid_sternum"))!, before.map((value) => factor * value) as typeof before), "mm").toBeLessThan(0.01);
  await size.getByRole("button", { name: "Take out" }).click();
  await expect(size).not.toContainText("Scaled by");
  expect(await hook.pick(page, "mid_sternum")).toEqual(before);
  await page.getByRole("button", { name: "Undo “true size”" }).focus();
  await page.keyboard.press("Control+z"); // a fit of the size that goes may run
  await expect(size).toContainText(`Scaled by ${factor.toFixed(3)}: `);
  expect(await page.evaluate(() => window.__breastrig!.state().scan!.info.scale!.factor)).toBe(factor);
  await page.keyboard.press("Control+y");
  await expect(size).not.toContainText("Scaled by");
  expect(troubles.filter((each) => !/422 .*\/length$/.test(each)), "but for the length that was refused").toEqual([]);
});

test("marks that both scans show in their colours are found, accepted one and all, and kept with both", async ({ page, base, troubles }, info) => {
  const folder = info.outputPath("files");
  const { path, env } = helper("marked_example.py");
  execFileSync(findPython(), [path, folder], { env, stdio: "inherit" });
  const truth = JSON.parse(readFileSync(join(folder, "truth.json"), "utf8")) as Record<string, LandmarkFile["landmarks"]>;
  const made: { scan: Scan; fit: string }[] = [];
  for (const stance of ["standing", "supine"]) {
    const file = { name: `${stance}.zip`, mimeType: "application/zip", buffer: readFileSync(join(folder, `${stance}.zip`)) };
    const scan = (await (await page.request.post(`${base}/api/scans`, { multipart: { file, units: "m" } })).json()) as Scan;
    if (made[0]) await page.request.put(`${base}/api/scans/${scan.id}/patient`, { data: { patient: made[0].scan.patient, same_as: [made[0].scan.id] } });
    const landmarks = truth[stance]!;
    await page.request.put(base + scan.links.landmarks, { data: { unit: "mm", landmarks } });
    const fit = (await (await page.request.post(`${base}/api/fits`, { data: { scan: scan.id, stance, landmarks, refine: false } })).json()) as { id: string };
    made.push({ scan, fit: fit.id });
  }
  for (const { fit } of made) await expect.poll(async () => ((await (await page.request.get(`${base}/api/fits/${fit}`)).json()) as { state: string }).state).toBe("done");
  const [here, other] = made as [(typeof made)[0], (typeof made)[0]];
  await page.goto(`${base}/#scan=${here.scan.id}&fit=${here.fit}&step=points&other=${other.scan.id}&otherfit=${other.fit}`);
  await hook.ready(page);
  await untilFitted(page);

  const box = page.getByRole("region", { name: "Marks by colour" });
  await box.getByRole("button", { name: "Find marks" }).click();
  await expect(box).toContainText("4 pairs are proposed; check each.");
  await expect(page.locator(".pin[data-found=m1] .mark"), "on both panes").toHaveCount(2);
  const kept = async ({ scan }: { scan: Scan }): Promise<string[]> => Object.keys(((await (await page.request.get(base + scan.links.landmarks)).json()) as LandmarkFile).marks ?? {}).sort();
  expect(await kept(here), "nothing is a mark before it is accepted").toEqual([]);
  await box.getByRole("button", { name: "Accept the mark m2" }).click();
  for (const each of [here, other]) await expect.poll(() => kept(each)).toEqual(["m2"]);
  await expect(page.locator("[data-mark=m2]")).toHaveClass(/is-placed/);
  await box.getByRole("button", { name: "Dismiss the mark m1" }).click();
  await expect(box.locator("[data-found]")).toHaveCount(2);
  await box.getByRole("button", { name: "Accept all 2" }).click();
  for (const each of [here, other]) await expect.poll(() => kept(each)).toEqual(["m2", "m3", "m4"]);
  await expect(box.locator("[data-found]")).toHaveCount(0);
  await box.getByRole("button", { name: "Find marks" }).click();
  await expect(box, "what is a mark already is not proposed again").toContainText("1 pair is proposed; check it.");
  await expect(box.locator("[data-found=m1]")).toHaveCount(1);
  await thumb(page, "supine").click();
  await expect(page.locator("[data-mark=m4]"), "there too").toHaveClass(/is-placed/);
  expect(troubles).toEqual([]);
});
