// The day of an image: a zip of DICOM files with several series, a SEG of the lesion alone and two scans are dropped together; the
// image is seen in slices, and the lesion on all three, with its numbers as radiology writes them, in plan and report.
import { execFileSync } from "node:child_process";
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { expect, type Page } from "@playwright/test";
import type { Fit, PlanOnScan, Vector } from "../src/api/types";
import { overlaps, seriousFindings } from "./audit";
import { distance, drop, hook, planItem, test, until } from "./page";
import { findPython, helper } from "./service";

interface Truth {
  readonly landmarks: Readonly<Record<"prone" | "standing" | "supine", Record<string, Vector>>>;
  readonly lesion: Vector; // standing
}

/** Grey of the canvas of a slice where its ball is drawn, and its size. */
const greyAtBall = (page: Page) =>
  page.evaluate(() => {
    const canvas = document.querySelector<HTMLCanvasElement>(".is-axial .slice-grey")!;
    const [box, ball] = [canvas, document.querySelector(".is-axial .slice-ball")!].map((each) => each.getBoundingClientRect()) as [DOMRect, DOMRect];
    const pixel = (x: number, y: number): number => canvas.getContext("2d")!.getImageData(Math.floor((canvas.width * (x - box.x)) / box.width), Math.floor((canvas.height * (y - box.y)) / box.height), 1, 1).data[0]!;
    return { lesion: pixel(ball.x + ball.width / 2, ball.y + ball.height / 2), air: pixel(box.x + 2, box.y + 2), wide: canvas.width };
  });

test("dropped together: image, lesion and scans become one patient, the lesion is seen in the image and on both bodies", async ({ page, base, troubles }, info) => {
  const folder = info.outputPath("files");
  const { path, env } = helper("image_day_files.py");
  execFileSync(findPython(), [path, folder], { env, stdio: "inherit" });
  const truth = JSON.parse(readFileSync(join(folder, "truth.json"), "utf8")) as Truth;
  await page.setViewportSize({ width: 1280, height: 720 });
  await page.goto(base);
  await until(page, () => window.__breastrig);

  await test.step("which series is asked with pictures; then all four files find their place", async () => {
    await drop(page, ["standing.ply", "lesion.dcm", "image.zip", "supine.ply"].map((name) => ({ name, path: join(folder, name) })));
    const card = page.getByRole("region", { name: "Which series?" });
    await expect(card.locator("img")).toHaveCount(2);
    expect.soft(await seriousFindings(page)).toEqual([]);
    await card.getByRole("button", { name: /t1 dynamic/ }).press("Enter");
    await expect(page.locator(".thumb")).toHaveCount(3);
    await expect(page.getByRole("alert").filter({ visible: true })).toHaveCount(0);
  });

  const fits = await test.step("each is fitted with its landmarks", async () => {
    const patient = await page.evaluate(() => window.__breastrig!.state().scan!.info.patient);
    const { scans } = (await (await page.request.get(`${base}/api/patients/${patient}`)).json()) as { scans: { id: string; kind: string }[] };
    const started: Record<string, Pick<Fit, "id"> & { scan: string }> = {};
    for (const { id: scan, kind } of scans) {
      const stance = kind === "image" ? "prone" : "standing" in started ? "supine" : "standing"; // in the order in which they came
      const { id } = (await (await page.request.post(`${base}/api/fits`, { data: { scan, stance, landmarks: truth.landmarks[stance] } })).json()) as Fit;
      started[stance] = { id, scan };
    }
    for (const { id } of Object.values(started)) await expect.poll(async () => ((await (await page.request.get(`${base}/api/fits/${id}`)).json()) as Fit).state).toBe("done");
    const { prone, standing } = started;
    await page.goto("about:blank");
    await page.goto(`${base}/#scan=${prone!.scan}&fit=${prone!.id}&step=plan&other=${standing!.scan}&otherfit=${standing!.id}`);
    await hook.ready(page);
    return started;
  });

  await test.step("the slices show the image, the lesion is light in its ring, air is black", async () => {
    await planItem(page, "Lesion 1").click();
    await expect(page.locator(".slice-grey:visible")).toHaveCount(3);
    await expect(page.locator(".slice .slice-ball")).toHaveCount(3);
    const seen = await greyAtBall(page);
    expect(seen.air).toBeLessThan(20);
    expect(seen.lesion).toBeGreaterThan(60);
    const picture = page.locator(".is-axial .slice-picture");
    await expect(picture).toHaveAccessibleName(/comma and full stop darken and lighten its image/);
    await picture.press("Comma");
    await expect.poll(async () => (await greyAtBall(page)).lesion, "darker").toBeLessThan(seen.lesion);
    await picture.press("0");
    await expect.poll(async () => (await greyAtBall(page)).lesion).toBe(seen.lesion);
    expect.soft(await seriousFindings(page)).toEqual([]);
    expect.soft(await overlaps(page)).toEqual([]);
  });

  await test.step("what radiology wrote beside its place: a contradiction is red, the place as it writes it is not", async () => {
    const written = page.getByRole("textbox", { name: "What radiology wrote" });
    await test.step("what the service says of the plan meanwhile takes no word that is being typed", async () => {
      let release!: () => void;
      const held = new Promise<void>((done) => (release = done));
      await page.route(/\/plan\.json/, async (route) => held.then(() => route.continue()));
      const isAsked = page.waitForRequest(/\/plan\.json/);
      const said = () => page.evaluate(() => window.__breastrig!.state().drawn.onScan?.plan.lesions[0]?.radiology?.text ?? null);
      await written.fill("at 3");
      await written.press("Enter");
      await isAsked;
      await written.fill("right, 6 o'clock");
      release();
      await expect.poll(said).not.toBeNull();
      await expect(written).toHaveValue("right, 6 o'clock");
      await page.unroute(/\/plan\.json/);
    });
    await written.press("Enter");
    await expect(page.locator(".lesion-contradicted")).toHaveText("Radiology wrote right; this lesion lies in the left breast.");
    await written.fill((await page.locator(".lesion-view dd", { hasText: /^left, / }).textContent())!);
    await written.press("Enter");
    await expect(page.getByText(/^(Agrees with radiology by side and quadrant|Same side as radiology wrote)\.$/)).toBeVisible();
  });

  await test.step("another one by three taps, larger by a key, taken out again", async () => {
    await page.getByRole("button", { name: "Mark a lesion" }).click();
    const skin = (await page.locator(".is-axial .slice-skin").boundingBox())!;
    const [x, y] = [skin.x + 0.25 * skin.width, skin.y + 0.4 * skin.height];
    for (const [dx, dy] of [[0, 0], [14, 0], [0, 18]] as const) await page.mouse.click(x + dx, y + dy);
    await until(page, () => window.__breastrig!.state().drawn.lesions.length === 2);
    const radius = () => page.evaluate(() => window.__breastrig!.state().drawn.lesions[1]!.radius_mm);
    const before = await radius();
    expect(before).toBeGreaterThan(3);
    await page.getByRole("button", { name: "Move Lesion 2" }).click();
    await page.locator(".is-axial .slice-picture").press("]");
    expect(await radius()).toBeCloseTo(before + 0.5, 1);
    await page.getByRole("button", { name: "Take Lesion 2 out of the plan" }).click();
    await until(page, () => window.__breastrig!.state().drawn.lesions.length === 1);
  });

  await test.step("closed, the image is given back", async () => {
    await page.locator(".is-axial .slice-picture").press("Escape");
    expect(await page.locator(".slice-grey").evaluateAll((all) => all.map((each) => (each as HTMLCanvasElement).width))).toEqual([0, 0, 0]);
  });

  await test.step("it is on both bodies, where it is, and in the report", async () => {
    for (const stance of ["standing", "supine"]) {
      const { lesions: [lesion] } = (await (await page.request.get(`${base}/api/fits/${fits[stance]!.id}/plan.json`)).json()) as PlanOnScan;
      expect([lesion!.name, lesion!.carried, lesion!.clock!.side]).toEqual(["Lesion 1", true, "L"]);
      if (stance === "standing") expect(distance(lesion!.center, truth.lesion)).toBeLessThan(lesion!.error_mm!);
    }
    const report = info.outputPath("report.pdf");
    writeFileSync(report, await (await page.request.get(`${base}/api/fits/${fits.standing!.id}/report.pdf`)).body());
    const words = execFileSync(findPython(), ["-c", "import sys, pypdf; print(' '.join(' '.join(page.extract_text() for page in pypdf.PdfReader(sys.argv[1]).pages).split()))", report], { encoding: "utf8" });
    expect(words).toMatch(/Lesion: Lesion 1.*nipple, left \d+ mm.*by the clock left, .*radiology Same side as radiology wrote\./);
  });
  expect(troubles.filter((each) => !each.includes("422")), "but for the question").toEqual([]);
});
