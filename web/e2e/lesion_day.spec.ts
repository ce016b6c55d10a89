// A lesion that an MRI shows: its label map uploaded by chooser and by drop, its side asked where the file does not say it,
// its segments listed, and the lesion found in the same breast of a standing scan, in the plan.
import { execFileSync } from "node:child_process";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { expect, type Page } from "@playwright/test";
import type { PlanOnScan, Vector } from "../src/api/types";
import { overlaps, seriousFindings, smallTargets } from "./audit";
import { distance, drop, hook, planItem, test, thumb, until, untilFitted } from "./page";
import { mmFrom } from "../src/ui/units";
import { findPython, helper } from "./service";

let folder = "";
const made = (name: string): string => join(folder, name);
const json = (name: string): unknown => JSON.parse(readFileSync(made(name), "utf8"));

test.beforeAll(({}, info) => {
  folder = info.outputPath("files");
  const { path, env } = helper("lesion_day_files.py");
  execFileSync(findPython(), [path, folder], { env, stdio: "inherit" });
});

const lesions = (page: Page) => page.evaluate(() => window.__breastrig!.state().drawn.lesions.map(({ name, center, radius_mm }) => ({ name, center, radius_mm })));
const scanId = (page: Page) => page.evaluate(() => window.__breastrig!.state().scan?.info.id ?? null);
const another = (page: Page, before: string | null) => until(page, (id) => { const { scan, loading } = window.__breastrig!.state(); return scan && !loading && scan.info.id !== id; }, before);

async function segmentsOf(page: Page): Promise<string[]> {
  await expect(page.locator(".segments li").first()).toBeVisible();
  return page.locator(".segments li").evaluateAll((rows) => rows.map((row) => `${row.querySelector("strong")!.textContent} ${row.querySelector("select")?.value ?? ""}`));
}

test("which side is left is asked with pictures; called off, nothing is uploaded; answered, the lesion is on that side", async ({ page, base }) => {
  const kept: string[] = [];
  page.on("response", (answer) => answer.status() === 201 && kept.push(answer.url()));
  await page.goto(base);
  await page.locator("#scan-file").setInputFiles(made("no_side.nii.gz"));
  const dialog = page.getByRole("region", { name: "Which side is the patient's left?" });
  await expect(dialog.locator("img").first()).toBeVisible();
  await expect(dialog).toContainText("does not say which side is left");
  expect.soft(await seriousFindings(page)).toEqual([]);
  expect.soft(await smallTargets(page)).toEqual([]);
  await page.setViewportSize({ width: 1280, height: 720 });
  expect(await dialog.locator("[data-value]").count(), "as many as a file without any code has").toBe(8);
  await expect(dialog.getByRole("button", { name: "Cancel" }), "without a scroll").toBeInViewport({ ratio: 1 });
  await page.keyboard.press("Enter");
  await expect(dialog, "no answer is the default").toBeVisible();
  await page.keyboard.press("Escape");
  await expect(dialog).toBeHidden();
  expect([kept, await scanId(page)]).toEqual([[], null]);

  for (const [frame, word, side] of [["LPS", "left", 1], ["RPS", "right", -1]] as const) {
    const before = await scanId(page);
    if (before === null) await page.locator("#scan-file").setInputFiles(made("no_side.nii.gz"));
    else await drop(page, [{ name: "no_side.nii.gz", path: made("no_side.nii.gz") }]);
    const choice = dialog.locator(`[data-value=${frame}]`);
    await expect(choice).toContainText(new RegExp(`Lesion 1 ${word}`));
    await choice.press("Enter");
    await another(page, before);
    const [lesion] = await lesions(page);
    expect(side * lesion!.center[0]).toBeGreaterThan(30);
    expect(lesion!.radius_mm).toBeCloseTo(7, 0);
  }
});

/** Where a thing lies in the box of another: 0 at its left and upper edge, 1 at the right and lower one. */
async function within(page: Page, pane: string, thing: string, box: string): Promise<[number, number]> {
  const found = await page.waitForFunction(([inner, outer]) => { // both of one moment: a slice may be drawn again between two questions
    const [a, b] = [inner, outer].map((name) => document.querySelector(name!)?.getBoundingClientRect());
    return a && b && b.width > 0 ? ([(a.x + a.width / 2 - b.x) / b.width, (a.y + a.height / 2 - b.y) / b.height] as [number, number]) : null;
  }, [`.slice.is-${pane} ${thing}`, `.slice.is-${pane} ${box}`]);
  return (await found.jsonValue())!;
}

test("an MRI stands in three slices and as a body with one cross: sides, places and keys are true", async ({ page, base, troubles }) => {
  await page.setViewportSize({ width: 1280, height: 720 });
  await page.goto(base);
  await page.locator("#scan-file").setInputFiles(made("balls.nii.gz")); // half balls of 60 mm around (±65, -10, 140), a lesion at (60, -35, 150): left, back, head
  await hook.ready(page);
  await thumb(page, "image").click();
  const title = (pane: string) => page.locator(`.slice.is-${pane} .slice-title`);
  await expect(title("sagittal")).toHaveText(/60\smm left/);
  await expect(title("axial")).toHaveText(/150\smm head/);
  await expect(title("coronal")).toHaveText(/35\smm front/);
  await expect(page.locator(".slice .slice-ball")).toHaveCount(3);

  await test.step("the lesion in the skin's section: left is right, the front is up and left, the head is up", async () => {
    for (const [pane, x, y] of [["axial", 190 / 260, 0.5], ["sagittal", 0.5, 0.44], ["coronal", 0.75, 0.41]] as const) {
      const place = await within(page, pane, ".slice-ball", ".slice-skin");
      expect(Math.abs(place[0] - x), `${pane}: ${place.join(" ")}`).toBeLessThan(0.03);
      expect(Math.abs(place[1] - y), `${pane}: ${place.join(" ")}`).toBeLessThan(0.03);
    }
    for (const pane of ["axial", "coronal"]) {
      const [right, left] = await Promise.all(["right", "left"].map(async (side) => (await page.locator(`.slice.is-${pane} .side-${side}`).boundingBox())!.x));
      expect(right!).toBeLessThan(left!);
    }
  });
  expect.soft(await seriousFindings(page)).toEqual([]);
  expect.soft(await overlaps(page)).toEqual([]);
  expect.soft(await smallTargets(page)).toEqual([]);

  const cross = () => page.evaluate(() => window.__breastrig!.state().slices.cross!.at.map(Math.round));
  await test.step("one cross in all: put by hand in one, moved by keys in another, read out", async () => {
    const skin = (await page.locator(".is-coronal .slice-skin").boundingBox())!;
    await page.mouse.click(skin.x + 0.1 * skin.width, skin.y + skin.height / 2); // the patient's right breast
    const [left] = await cross();
    expect(left!).toBeLessThan(-80);
    await expect(title("sagittal")).toContainText("mm right");
    const [, height] = [...await within(page, "axial", ".slice-cross", ".slice-skin")];
    expect(height).toBeCloseTo(0.5, 1); // still 35 mm to the front
    const before = await cross();
    const axial = page.locator(".is-axial .slice-picture");
    await axial.focus();
    for (const key of ["ArrowRight", "ArrowRight", "Shift+ArrowUp", "PageUp"]) await page.keyboard.press(key);
    expect(await cross()).toEqual([before[0]! + 2, before[1]! - 5, before[2]! + 1]);
    await expect(page.locator(".slices [role=status].visually-hidden")).toHaveText(/Cross \d+\smm right, 40\smm front, \d+\smm head of the scan's zero, \d+\smm from the centre of Lesion 1/);
    await page.getByRole("slider", { name: "Place of the sagittal slice" }).fill("60");
    expect((await cross())[0]).toBe(60);
  });

  await test.step("on the body as well: a click on the skin puts it there", async () => {
    const at = await hook.project(page, [-65, -70, 140]);
    await page.mouse.click(at.x, at.y);
    const [x, y, z] = await cross();
    expect(distance([x!, y!, z!], [-65, -70, 140])).toBeLessThan(6);
    const flat = (await page.locator(".stage .body-cross.is-flat").boundingBox())!;
    expect(Math.abs(flat.y - at.y)).toBeLessThan(4);
  });

  await test.step("keys, the wheel with Ctrl and two fingers zoom all slices alike, around the place that is pointed at", async () => {
    const box = (of: string) => page.evaluate((one) => document.querySelector(one)!.getBoundingClientRect().toJSON() as DOMRect, of); // balls are drawn anew
    const wide = async () => (await box(".is-axial .slice-ball")).width;
    const picture = page.locator(".is-axial .slice-picture");
    for (const [plane, at] of [["axial", "150"], ["sagittal", "60"], ["coronal", "35"]] as const) await page.getByRole("slider", { name: `Place of the ${plane} slice` }).fill(at);
    await expect(page.locator(".slice .slice-ball")).toHaveCount(3);
    const whole = await wide();
    await picture.press("+");
    await picture.press("+");
    await expect.poll(wide).toBeGreaterThan(1.4 * whole);
    expect((await page.locator(".is-sagittal .scale-bar").boundingBox())!.width).toBeCloseTo((await page.locator(".is-axial .scale-bar").boundingBox())!.width, 0);
    const ball = async () => { const { x, y, width, height } = await box(".is-axial .slice-ball"); return { x: x + width / 2, y: y + height / 2 }; };
    const at = await ball();
    const before = await wide();
    await page.mouse.move(at.x, at.y);
    await page.keyboard.down("Control");
    await page.mouse.wheel(0, -40);
    await page.keyboard.up("Control");
    await expect.poll(wide).toBeGreaterThan(1.2 * before);
    expect(distance([(await ball()).x, (await ball()).y, 0], [at.x, at.y, 0]), "it stays under the pointer").toBeLessThan(3);
    const all = await box(".is-axial .slice-picture");
    const [x, y] = [all.x + all.width / 2, all.y + all.height / 2];
    const now = await cross();
    const zoomed = await wide();
    const fingers = await page.context().newCDPSession(page);
    const touch = (type: "touchStart" | "touchMove" | "touchEnd", ...points: [number, number][]) => fingers.send("Input.dispatchTouchEvent", { type, touchPoints: points.map(([px, py], id) => ({ x: px, y: py, id })) });
    await touch("touchStart", [x - 80, y]);
    await touch("touchStart", [x - 80, y], [x + 80, y]);
    for (let step = 1; step <= 4; step += 1) await touch("touchMove", [x - 80 + 10 * step, y], [x + 80 - 10 * step, y]);
    await touch("touchEnd");
    await expect.poll(wide).toBeLessThan(0.7 * zoomed);
    expect(await cross(), "two fingers move nothing").toEqual(now);
    for (let i = 0; i < 12; i += 1) await picture.press("-");
    await expect.poll(wide).toBeCloseTo(whole, 0);
    await page.keyboard.press("?");
    await expect(page.locator(".key-help")).toContainText("Page Up and Page Down go through, + and − zoom");
    await page.keyboard.press("Escape");
  });

  await test.step("a double click enlarges one; Escape goes back, and once more closes", async () => {
    const picture = page.locator(".is-sagittal .slice-picture");
    await picture.dblclick({ position: { x: 120, y: 120 } });
    await expect(page.locator(".slice:visible")).toHaveCount(1);
    await expect(page.locator(".stage canvas.view")).toBeHidden();
    await picture.press("Escape");
    await expect(page.locator(".slice:visible")).toHaveCount(3);
    await picture.press("Escape");
    await expect(page.locator(".slice:visible")).toHaveCount(0);
    await expect(page.locator(".stage canvas.view")).toBeVisible();
  });

  await test.step("on a telephone one pane, chosen by its name", async () => {
    await page.setViewportSize({ width: 390, height: 844 });
    await thumb(page, "image").click();
    await expect(page.locator(".slice:visible")).toHaveCount(1);
    await page.getByRole("group", { name: "Slices" }).getByRole("button", { name: "Coronal" }).click();
    await expect(page.locator(".slice.is-coronal .slice-ball")).toBeVisible();
    expect.soft(await overlaps(page)).toEqual([]);
    await page.getByRole("group", { name: "Slices" }).getByRole("button", { name: "Body" }).click();
    await expect(page.locator(".slice:visible")).toHaveCount(0);
    await expect(page.locator(".stage canvas.view")).toBeVisible();
  });
  expect(troubles).toEqual([]);
});

test("an MRI's lesion is found in the same breast of a standing scan, with its numbers in the plan and behind a link", async ({ page, base }) => {
  await page.goto(base);
  await test.step("segments of a .nii.gz from the chooser", async () => {
    await page.locator("#scan-file").setInputFiles(made("mri.nii.gz"));
    await hook.ready(page);
    expect(await segmentsOf(page)).toEqual(["Tissue 1 tissue", "Lesion 1 lesion"]);
    await page.locator("[popovertarget=size-word]").click();
    await expect(page.getByText("The image itself says how large it is."), "its unit is its own").toBeVisible();
    await page.keyboard.press("Escape");
    await expect(page.locator(".facts")).toContainText("prone, as in an MRI");
    expect((await lesions(page)).map(({ name }) => name)).toEqual(["Lesion 1"]);
    expect.soft(await seriousFindings(page)).toEqual([]);
    expect.soft(await overlaps(page)).toEqual([]);
  });

  await test.step("taken otherwise and back: each time one upload stays", async () => {
    const said = page.getByText("This label map shows no lesion");
    for (const [take, expected] of [["tissue", []], ["lesion", ["Lesion 1"]]] as const) {
      const before = await scanId(page);
      await page.locator(".segments [data-segment='2'] select").selectOption(take);
      await page.getByRole("button", { name: "Read the file again with these choices" }).click();
      await another(page, before);
      expect((await page.request.get(`${base}/api/scans/${before}`)).status()).toBe(404);
      expect((await lesions(page)).map(({ name }) => name)).toEqual(expected);
      await expect(said).toBeVisible({ visible: expected.length === 0 });
    }
  });

  await test.step("a broken map is one sentence, and nothing is lost", async () => {
    const before = await scanId(page);
    await drop(page, [{ name: "broken.nii.gz", path: made("broken.nii.gz") }]);
    const alert = page.getByRole("alert").filter({ visible: true });
    await expect(alert).toHaveText(/^[A-Z].*[^.]\.$/);
    await expect(alert).not.toContainText(/Traceback|Error|\//);
    expect([await scanId(page), (await lesions(page)).length]).toEqual([before, 1]);
  });

  await test.step("a zipped DICOM SEG let go over the page: the file's own words are shown, and not kept", async () => {
    const before = await scanId(page);
    await drop(page, [{ name: "seg.zip", path: made("seg.zip") }]);
    await another(page, before);
    expect(await segmentsOf(page)).toEqual(["Tissue 1 tissue", "Lesion 1 lesion"]);
    await expect(page.locator(".segments")).toContainText("Index lesion");
    const kept = await (await page.request.get(`${base}/api/scans/${await scanId(page)}`)).text();
    expect(kept).not.toContain("Index lesion");
    expect(await page.evaluate(() => [localStorage, sessionStorage].map((kept) => JSON.stringify(Object.entries(kept))).join() + location.href)).not.toContain("Index lesion");
  });

  const fit = async (landmarks: string): Promise<string> => {
    await page.keyboard.press("2");
    await page.locator("#landmark-file").setInputFiles(made(landmarks));
    const count = Object.keys((json(landmarks) as { landmarks: object }).landmarks).length;
    await expect.poll(() => hook.pickCount(page)).toBe(count);
    await page.keyboard.press("1");
    await page.getByRole("button", { name: /^Fit with \d+ landmarks$/ }).press("Enter");
    await untilFitted(page);
    return (await hook.fit(page))!.id;
  };

  await test.step("fitted; what the MRI does not show is not proposed", async () => {
    await page.keyboard.press("2");
    await expect(page.getByText(/^Not proposed: .*navel.*The scan shows no skin/)).toBeVisible();
    await fit("prone.json");
  });

  const standing = await test.step("a standing scan of the same patient", async () => {
    const before = await scanId(page);
    await page.locator("#add-scan").click();
    await page.locator("#second-scan-file").setInputFiles(made("standing.ply"));
    await another(page, before);
    await expect(page.locator(".doubt-card")).toBeHidden();
    return fit("standing.json");
  });

  await test.step("there it is, in the plan and for who has a link", async () => {
    const plan = (await (await page.request.get(`${base}/api/fits/${standing}/plan.json`)).json()) as PlanOnScan;
    const [lesion] = plan.lesions;
    expect([plan.lesions.length, lesion!.name, lesion!.carried]).toEqual([1, "Lesion 1", true]);
    const right = json("lesion.json") as Vector;
    expect(lesion!.center[0], "the patient's left").toBeGreaterThan(30);
    expect(distance(lesion!.center, right)).toBeLessThan(lesion!.error_mm!);
    expect(lesion!.error_mm).toBeLessThan(30);
    await page.keyboard.press("3");
    await planItem(page, "Lesion 1").click();
    await expect(page.getByRole("img", { name: /^\d+\smm below the skin \(90\s%: \d+–\d+\smm\)$/ })).toBeVisible();
    await expect(page.locator(".slice .slice-ball"), "in the MRI's slices, beside the standing body").toHaveCount(3);
    await expect(page.locator(".is-sagittal .slice-title")).toContainText("patient's left");
    const [x] = await within(page, "axial", ".slice-ball", ".slice-skin");
    expect(x, "left is right in the picture").toBeGreaterThan(0.6);
    await expect(page.locator(".stage canvas.view")).toBeVisible();
    await expect(page.locator(".stage .body-cross.is-steep")).toBeVisible();
    const there = await hook.project(page, lesion!.center.map((value) => mmFrom(value, plan.unit)) as Vector);
    const steep = (await page.locator(".stage .body-cross.is-steep").boundingBox())!;
    expect(Math.abs(steep.x - there.x), "through the lesion where it lies standing").toBeLessThan(3);
    const link = (await (await page.request.post(`${base}/api/fits/${standing}/shares`, { data: { expires_in_days: 1, scan: "plain" } })).json()) as { url: string };
    const visitor = await page.context().browser()!.newPage();
    await visitor.goto(new URL(link.url, base).href);
    await visitor.getByRole("button", { name: "Lesion 1" }).click();
    await expect(visitor.getByRole("img", { name: /^\d+\smm below the skin/ }), "who has a link sees how deep it lies").toBeVisible();
    await expect(visitor.getByRole("img", { name: /^(axial|sagittal|coronal) slice through Lesion 1$/ })).toHaveCount(3);
    expect(await visitor.locator(".lesion-slices .slice-of-skin").first().evaluate((path) => (path as SVGPathElement).getTotalLength())).toBeGreaterThan(200);
    await visitor.close();
  });
});
