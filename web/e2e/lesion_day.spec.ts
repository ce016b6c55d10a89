// A lesion that an MRI shows: its label map uploaded by chooser and by drop, its side asked where the file does not say it,
// its segments listed, and the lesion found in the same breast of a standing scan, in the plan and in the report.
import { execFileSync } from "node:child_process";
import { readFileSync, writeFileSync } from "node:fs";
import { basename, join } from "node:path";
import { expect, type Page } from "@playwright/test";
import type { PlanOnScan, Vector } from "../src/api/types";
import { overlaps, seriousFindings, smallTargets } from "./audit";
import { distance, hook, planItem, test, until, untilFitted } from "./page";
import { findPython, helper } from "./service";

let folder = "";
const made = (name: string): string => join(folder, name);
const json = (name: string): unknown => JSON.parse(readFileSync(made(name), "utf8"));

test.beforeAll(({}, info) => {
  folder = info.outputPath("files");
  const { path, env } = helper("lesion_day_files.py");
  execFileSync(findPython(), [path, folder], { env, stdio: "inherit" });
});

/** A file let go over the page, as a hand does it. */
async function drop(page: Page, file: string): Promise<void> {
  const transfer = await page.evaluateHandle(({ name, content }) => {
    const bytes = Uint8Array.from(atob(content), (letter) => letter.charCodeAt(0));
    const given = new DataTransfer();
    given.items.add(new File([bytes], name));
    return given;
  }, { name: basename(file), content: readFileSync(file).toString("base64") });
  await page.locator(".stage").dispatchEvent("drop", { dataTransfer: transfer });
}

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
  const dialog = page.getByRole("dialog", { name: "Which side is the patient's left?" });
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
    else await drop(page, made("no_side.nii.gz"));
    const choice = dialog.locator(`[data-value=${frame}]`);
    await expect(choice).toContainText(new RegExp(`Lesion 1 ${word}`));
    await choice.press("Enter");
    await another(page, before);
    const [lesion] = await lesions(page);
    expect(side * lesion!.center[0]).toBeGreaterThan(30);
    expect(lesion!.radius_mm).toBeCloseTo(7, 0);
  }
});

test("an MRI's lesion is found in the same breast of a standing scan, with its numbers in plan and report", async ({ page, base }, info) => {
  await page.goto(base);
  await test.step("segments of a .nii.gz from the chooser", async () => {
    await page.locator("#scan-file").setInputFiles(made("mri.nii.gz"));
    await hook.ready(page);
    expect(await segmentsOf(page)).toEqual(["Tissue 1 tissue", "Lesion 1 lesion"]);
    await expect(page.getByLabel("Wrong unit? Read the file as"), "its unit is its own").toBeHidden();
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
    await drop(page, made("broken.nii.gz"));
    const alert = page.getByRole("alert").filter({ visible: true });
    await expect(alert).toHaveText(/^[A-Z].*[^.]\.$/);
    await expect(alert).not.toContainText(/Traceback|Error|\//);
    expect([await scanId(page), (await lesions(page)).length]).toEqual([before, 1]);
  });

  await test.step("a zipped DICOM SEG let go over the page: the file's own words are shown, and not kept", async () => {
    const before = await scanId(page);
    await drop(page, made("seg.zip"));
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
    await expect(page.getByRole("dialog")).toHaveCount(0);
    return fit("standing.json");
  });

  await test.step("there it is, in plan and report", async () => {
    const plan = (await (await page.request.get(`${base}/api/fits/${standing}/plan.json`)).json()) as PlanOnScan;
    const [lesion] = plan.lesions;
    expect([plan.lesions.length, lesion!.name, lesion!.carried]).toEqual([1, "Lesion 1", true]);
    const right = json("lesion.json") as Vector;
    expect(lesion!.center[0], "the patient's left").toBeGreaterThan(30);
    expect(distance(lesion!.center, right)).toBeLessThan(lesion!.error_mm!);
    expect(lesion!.error_mm).toBeLessThan(30);
    await page.keyboard.press("3");
    await expect(planItem(page, "Lesion 1")).toBeVisible();
    const report = info.outputPath("report.pdf");
    writeFileSync(report, await (await page.request.get(`${base}/api/fits/${standing}/report.pdf`)).body());
    const words = execFileSync(findPython(), ["-c", "import sys, pypdf; print(' '.join(' '.join(page.extract_text() for page in pypdf.PdfReader(sys.argv[1]).pages).split()))", report], { encoding: "utf8" });
    expect(words).toMatch(/Lesion: Lesion 1.*radius [67][.\d]* mm.*to the skin \d+ mm.*nipple, left \d+ mm/);
  });
});
