// Other rigs than the torso: forearms, made by data only, served with `--model`.  Each is drawn where the service has it, by
// its way of skinning; one has its whole day: its scan is brought, fitted, drawn on, measured, reported and shared.
import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { expect, type Page } from "@playwright/test";
import { hook, look, openShare, planItem, test, until, untilFitted, untilStill } from "./page";
import { compare, type Made } from "./posed";
import { findPython, helper, startService } from "./service";

const PICTURES = process.env.BREASTRIG_E2E_PICTURES; // a folder: for whoever wants to look
let folder: string;
test.beforeAll(() => {
  folder = mkdtempSync(join(tmpdir(), "breastrig-e2e-"));
  const { path, env } = helper("skinned_forearms.py");
  execFileSync(findPython(), [path, folder], { env });
});
test.afterAll(() => rmSync(folder, { recursive: true, force: true }));

const forearm = (way: "dual_quaternion" | "corrective", file = "forearm.glb"): string => join(folder, way, file);

/** The forearm's own scan, brought to a service whose model it is, and fitted with its landmarks. */
async function comparedForearm(page: Page, base: string, way: "dual_quaternion" | "corrective"): Promise<void> {
  const file = { name: "scan.ply", mimeType: "application/octet-stream", buffer: readFileSync(forearm(way, "scan.ply")) };
  const scan = (await (await page.request.post(`${base}/api/scans`, { multipart: { file, units: "mm" } })).json()) as Made;
  const { landmarks } = JSON.parse(readFileSync(forearm(way, "landmarks.json"), "utf8")) as { landmarks: object };
  await compare(page, base, scan, landmarks);
}

test("the torso, which is skinned linearly, is drawn where the service has it", async ({ page, base, troubles }) => {
  const scan = (await (await page.request.post(`${base}/api/examples/standing`)).json()) as Made;
  await compare(page, base, scan, undefined, "paper"); // which has no smooth modes: their surface is drawn as it comes
  expect(troubles).toEqual([]);
});

/** When all that the page has asked for is there and drawn. */
async function settledPicture(page: Page): Promise<object> {
  await page.waitForLoadState("networkidle");
  let before = {};
  await expect
    .poll(
      async () => {
        await untilStill(page);
        const now = await hook.picture(page);
        const isSame = JSON.stringify(now) === JSON.stringify(before);
        before = now;
        return isSame;
      },
      { intervals: [1000] },
    )
    .toBe(true);
  return before;
}

test("a fit of the torso looks the same under a service whose model is a forearm, on the page and through its link; the forearm is drawn where the service has it", async ({ page }) => {
  const troubles: string[] = [];
  page.on("pageerror", (error) => troubles.push(error.message));
  const seen: object[] = [];
  let [at, shared] = ["", ""];
  for (const model of [[], ["--model", forearm("corrective")]]) {
    const { base, stop } = await startService({}, ["--no-token", ...model], join(folder, "data"));
    const post = async (path: string, data: object = {}) => (await (await page.request.post(base + path, { data })).json()) as Made & { url: string; links: Record<string, string> };
    try {
      if (at === "") {
        const scan = await post("/api/examples/standing");
        const fit = await post("/api/fits", { scan: scan.id, drawing: "lumpectomy", refine: false });
        await expect.poll(async () => ((await (await page.request.get(base + fit.links.self!)).json()) as { state: string }).state).toBe("done");
        at = `#scan=${scan.id}&fit=${fit.id}`;
        shared = (await post(fit.links.shares!)).url;
      }
      await page.goto(`${base}/${at}`);
      await hook.ready(page);
      await untilFitted(page);
      await look(page, "Model");
      await until(page, () => window.__breastrig!.state().fit?.surface);
      const rig = await settledPicture(page);
      await page.goto(base + shared);
      await until(page, () => window.__breastrig?.state().fit);
      seen.push({ rig, link: await settledPicture(page) });
      if (model.length > 0) await comparedForearm(page, base, "corrective");
    } finally {
      await stop();
    }
  }
  expect(troubles).toEqual([]);
  expect(seen[0]).toMatchObject({ rig: { isLost: false } });
  expect((seen[0] as { rig: { colours: number } }).rig.colours).toBeGreaterThan(100);
  expect(seen[1], "the same picture").toEqual(seen[0]);
});

test.describe("a forearm by dual quaternions, which the page poses itself", () => {
  let service: Awaited<ReturnType<typeof startService>>;
  test.use({ base: async ({}, use) => use(service.base) });
  test.beforeAll(async () => {
    service = await startService({}, ["--no-token", "--model", forearm("dual_quaternion")]);
  });
  test.afterAll(() => service.stop());

  test("it is fitted, drawn on, measured, reported and shared", async ({ page, base, troubles, browser }) => {
    await page.goto(base);
    await page.locator("#scan-file").setInputFiles(forearm("dual_quaternion", "scan.ply"));
    await hook.ready(page);
    await expect(page.locator("[popovertarget=model-word]")).toBeHidden(); // there is but this one
    const doubt = page.locator(".doubt-card"); // its size is far from that of most scans
    await expect(doubt).toContainText("less than scans usually show");
    await expect(doubt).not.toContainText("torso");
    await doubt.getByRole("button", { name: "Yes, the size is right" }).click();

    await test.step("its own landmarks are asked for", async () => {
      await page.keyboard.press("2");
      await expect(page.locator(".landmark .label-text")).toHaveText(["Elbow crease", "Tip of the radius", "Tip of the ulna", "Wrist crease", "Knuckle of the middle finger"]);
      await page.locator("#landmark-file").setInputFiles(forearm("dual_quaternion", "landmarks.json"));
      await expect.poll(() => hook.pickCount(page)).toBe(5);
    });

    await test.step("fitted, and not judged by what is known of another rig", async () => {
      await page.keyboard.press("1");
      await page.getByRole("button", { name: "Fit with 5 landmarks" }).click();
      await untilFitted(page);
      await expect(page.locator(".numbers .verdict")).toContainText("Not calibrated for this rig");
      expect(await page.evaluate(() => document.body.innerText)).not.toMatch(/\bbreasts?\b|nipple/i);
    });

    await test.step("its drawing lies on the skin", async () => {
      await page.keyboard.press("3");
      await page.getByRole("button", { name: "+ Add" }).click();
      await expect(page.locator("#add-menu .menu-item:visible > span:first-of-type"), "no tumour by the clock").toHaveText(["Incision", "Line", "Circle on the skin", "Lesion in an image", "Note", "Lines of a file"]);
      const before = await hook.picture(page);
      await page.locator("#add-menu").getByRole("button", { name: "Incision" }).click();
      await expect(planItem(page, "Incision")).toHaveCount(1);
      await expect.poll(async () => (await hook.picture(page)).checksum).not.toBe(before.checksum);
      if (PICTURES) await page.screenshot({ path: `${PICTURES}/drawn.png` });
    });

    await test.step("its lengths are measured, and the report is there", async () => {
      await page.keyboard.press("4");
      await page.locator("#measures").click();
      const dialog = page.getByRole("dialog", { name: "Measures" });
      await expect(dialog.locator("tbody tr[data-measure=radius]")).toHaveCount(2);
      await expect(dialog.locator("tbody tr[data-measure=radius]").first()).toContainText(/Length of the radius.*23\d/);
      if (PICTURES) await page.screenshot({ path: `${PICTURES}/measures.png` });
      const report = await page.request.get(base + (await dialog.locator("#report-both").getAttribute("href"))!);
      expect((await report.body()).subarray(0, 5).toString()).toBe("%PDF-");
      await page.keyboard.press("Escape");
      await expect(dialog).toBeHidden();
    });

    await test.step("and a colleague is shown it by a link", async () => {
      await openShare(page);
      const dialog = page.getByRole("dialog", { name: "Share this result" });
      await dialog.getByRole("button", { name: "Make a link" }).click();
      await expect(dialog.getByLabel("Address of the link")).not.toHaveValue("");
      const colleague = await (await browser.newContext()).newPage();
      await colleague.goto(await dialog.getByLabel("Address of the link").inputValue());
      await expect(colleague.getByText("fitted.glb")).toBeVisible();
      await expect(colleague.locator("[data-line=palmar]")).toHaveCount(1);
      if (PICTURES) await colleague.screenshot({ path: `${PICTURES}/shared.png` });
    });
    await test.step("it is drawn where the service has it", () => comparedForearm(page, base, "dual_quaternion"));
    expect(troubles).toEqual([]);
  });
});
