// A stance that was not scanned: predicted beside the scan, said to be so, with the pattern carried onto it; a scan takes its place.
import { join } from "node:path";
import { expect, type Page } from "@playwright/test";
import type { Fit } from "../src/api/types";
import { expectForEverybody } from "./audit";
import { addToPlan, hook, test, trueLandmarks, untilFitted } from "./page";

const other = (page: Page) =>
  page.evaluate(() => {
    const { stances } = window.__breastrig!.state();
    const { fit, drawn } = stances.other!;
    return { from: fit!.predictedFrom, stance: fit!.result!.stance, errors: drawn.onScan?.carried.shapes.map(({ error_mm }) => error_mm!) ?? [] };
  });

test("the stance that is missing is predicted, the pattern is carried there, and a scan takes its place", async ({ page, base, troubles }) => {
  const post = async (path: string, data: object = {}) => (await (await page.request.post(base + path, { data })).json()) as { id: string };
  const scan = await post("/api/examples/standing");
  const { id } = await post("/api/fits", { scan: scan.id, landmarks: trueLandmarks() });
  await expect.poll(async () => ((await (await page.request.get(`${base}/api/fits/${id}`)).json()) as Fit).state).toBe("done");
  await page.goto(`${base}/#scan=${scan.id}&fit=${id}&step=plan`);
  await hook.ready(page);
  await untilFitted(page);
  await addToPlan(page, /Wise/);

  await test.step("predicted", async () => {
    await page.locator("#add-scan").click();
    await page.getByRole("dialog").getByRole("button", { name: "Predict supine" }).press("Enter");
    await expect(page.getByRole("dialog")).toHaveCount(0);
    const pane = page.getByRole("region", { name: "Supine, predicted" });
    await expect(pane.getByText("predicted, not scanned", { exact: true })).toBeVisible();
    await expect(pane.getByText(/Predicted from the standing scan: .* Drawn lines are (one|two|three) fingers? wide\./)).toBeVisible();
    await pane.locator("canvas").click();
    expect((await page.evaluate(() => window.__breastrig!.state().fit!.id)), "nothing can be worked on there").toBe(id);
    await expect(page.getByText(/^The plan is shown on the supine body and follows every change/)).toBeVisible();
    const { from, stance, errors } = await other(page);
    expect([from, stance]).toEqual([id, "supine"]);
    expect(errors.length).toBeGreaterThan(0);
    expect(Math.min(...errors.flat().map((mm) => mm ?? 0))).toBeGreaterThan(0);
    expect(await page.evaluate(() => window.__breastrig!.state().stances.other!.scan!.mesh), "no scan stands for it").toBeNull();
    const halos = () => page.evaluate(() => ({ here: window.__breastrig!.halo(), there: window.__breastrig!.halo(true) }));
    await expect.poll(async () => (await halos()).there, "both panes show the bands").not.toBeNull();
    const { here, there } = await halos();
    expect(Math.max(...there!), "less is known of what nobody has scanned").toBeGreaterThan(Math.max(...here!));
    const made = page.locator(".thumb.is-predicted");
    await expect(made).toHaveAttribute("aria-pressed", "true");
    await made.click();
    await expect(pane).toBeHidden();
    expect(await page.evaluate(() => window.__breastrig!.state().scan!.info.id), "nobody works on it").toBe(scan.id);
    await made.click();
    await expect(pane).toBeVisible();
  });

  await test.step("everybody can read and press it", () => expectForEverybody(page, "predicted"));

  await test.step("it is there again after a reload, with what is planned", async () => {
    await page.reload();
    await expect(page.getByText("predicted, not scanned", { exact: true })).toBeVisible();
    await expect.poll(async () => (await other(page)).errors.length).toBeGreaterThan(0);
  });

  await test.step("a scan takes its place", async () => {
    await page.locator("#add-scan").click();
    await page.locator("#second-scan-file").setInputFiles(join(process.env.BREASTRIG_E2E_EXAMPLES!, "supine", "scan.ply"));
    await expect(page.getByRole("dialog")).toHaveCount(0);
    await expect.poll(() => page.evaluate(() => window.__breastrig!.state().stances.other?.fit?.id)).toBe(id);
    expect((await other(page)).from).toBeUndefined();
    await expect(page.getByText("predicted, not scanned", { exact: true })).toBeHidden();
  });
  expect(troubles).toEqual([]);
});
