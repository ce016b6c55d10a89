// The surgeon's tutorial can be followed as it is written, with the examples that ship, and says what the page shows; what it
// ends with goes to a hospital's archive.
import { spawn } from "node:child_process";
import { existsSync, mkdtempSync, readdirSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { expect } from "@playwright/test";
import type { Patient } from "../src/api/types";
import { test } from "./page";
import { findPython, helper, type Running, startService } from "./service";
import { followTutorial, SHIPPED, STEPS } from "./tutorialSteps";

test.use({ fitsAtOnce: true });
let service: Running | undefined;
const folder = mkdtempSync(join(tmpdir(), "breastrig-e2e-"));
const archives = join(folder, "archives.toml");
const { path: program, env } = helper("serve_archive.py");
const archive = spawn(findPython(), [program, folder], { env, stdio: "ignore" });
test.afterAll(async () => { // whatever has failed
  await service?.stop();
  archive.kill();
  rmSync(folder, { recursive: true, force: true });
});

test("the surgeon's tutorial, step by step", async ({ page }, info) => {
  test.slow(); // three fits of the scans as they ship
  await expect.poll(() => existsSync(archives)).toBe(true);
  const { base } = (service = await startService({ ...SHIPPED, BREASTRIG_ARCHIVES: archives }));
  let isLate = true; // the image's fit is still under way when the page first hears of it, as on a busy machine
  await page.route(/\/api\/patients\/[^/?]+$/, async (route) => {
    const response = await route.fetch();
    const patient = (await response.json()) as Patient;
    const fit = patient.scans.find(({ stance }) => stance === "prone")?.fit;
    const json = isLate && fit ? { ...patient, scans: patient.scans.map((scan) => (scan.fit === fit ? { ...scan, fit: { ...fit, state: "running" } } : scan)) } : patient;
    if (fit) isLate = false;
    await route.fulfill({ response, json });
  });
  const taken: string[] = [];
  await followTutorial(page, base, async (step) => {
    taken.push(step);
    if (step === "body") await expect.poll(() => page.evaluate(() => window.__breastrig!.state().stances.scans.map(({ fit }) => fit?.state))).toEqual(["done", "done", "done"]);
    if (step === "lines") {
      const lines = () =>
        page.evaluate(() => {
          const { drawn, stances } = window.__breastrig!.state();
          const carried = stances.other?.drawn.onScan?.carried.shapes ?? [];
          return drawn.lines.present.map(({ name }) => ({ name, isBanded: carried.find((each) => each.name === name)?.error_mm?.every((mm) => mm !== null && mm > 0) }));
        });
      await expect.poll(async () => (await lines()).filter(({ isBanded }) => isBanded).length, "the ink lies on the supine skin, with its band").toBe(6);
      expect((await lines()).map(({ name }) => name)).toContain("Tumour");
      // The panes have changed hands twice by now: the other body is still in the middle of its pane.
      const target = await page.evaluate(() => window.__breastrig!.other()!.pose.target);
      expect(Math.hypot(...target), "metres").toBeLessThan(0.15);
    }
    await page.screenshot({ path: info.outputPath(`${step}.png`) });
  });
  expect(taken).toEqual(STEPS);

  await page.getByRole("button", { name: "To the archive Archive" }).click();
  await expect(page.getByText("Archive has stored it.")).toBeVisible();
  expect(readdirSync(join(folder, "files"), { recursive: true, withFileTypes: true }).filter((each) => each.isFile())).toHaveLength(4);
  await page.getByRole("button", { name: "To the archive Gone" }).click();
  await expect(page.getByText(/cannot be reached\. Nothing was sent\./)).toBeVisible();
});
