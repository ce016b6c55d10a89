// The wrong woman's day: another patient's drawing, the same file twice, an item of a scan that is gone.
import { expect } from "@playwright/test";
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { hook, SCAN_FILE, test } from "./page";
import { sha256 } from "./shared";

const EXAMPLES = process.env.BREASTRIG_E2E_EXAMPLES!;

interface Scan {
  id: string;
  patient: string;
  patient_code: string;
  sha256: string;
  links: { plan: string };
}

test("what is another patient's is asked about, and nothing of it is taken before", async ({ page, base, troubles }, info) => {
  await page.goto(base);
  await page.locator("#scan-file").setInputFiles(SCAN_FILE);
  await hook.ready(page);
  const mine = (await page.evaluate(() => window.__breastrig!.state().scan!.info)) as unknown as Scan;
  expect(mine.sha256).toBe(sha256(readFileSync(SCAN_FILE)));
  const names = async (): Promise<string[]> => page.evaluate(() => window.__breastrig!.state().drawn.lines.present.map(({ name }) => name));

  await test.step("another's drawing in the same frame", async () => {
    await page.keyboard.press("4");
    const landmarks = JSON.parse(readFileSync(join(EXAMPLES, "standing", "landmarks.json"), "utf8")) as { unit?: string; landmarks: Record<string, [number, number, number]> };
    const { xiphoid, mid_sternum } = landmarks.landmarks;
    const shapes = [{ name: "hers", closed: false, points: [xiphoid, mid_sternum] }];
    const file = info.outputPath("another.json");
    writeFileSync(file, JSON.stringify({ schema: "breastrig/drawing@1", unit: landmarks.unit ?? "mm", patient: "P-9", scan_sha256: "ab".repeat(32), shapes }));
    await page.locator("#drawing-file").setInputFiles(file);
    const dialog = page.locator("#another-dialog");
    await expect(dialog).toContainText("patient P-9");
    await expect(dialog).toContainText(mine.patient_code);
    expect(await names()).toEqual([]);
    await dialog.getByRole("button", { name: "Do not import" }).click();
    await expect(dialog).toBeHidden();
    expect(await names()).toEqual([]);
    await page.locator("#drawing-file").setInputFiles(file);
    await dialog.getByRole("button", { name: /^Import/ }).click();
    await expect.poll(names).toEqual(["hers"]);
    await expect(page.locator(".drawing-saved")).toHaveText("Saved");
  });

  await test.step("the same file as the other stance", async () => {
    await page.locator("#add-stance").click();
    await page.locator("#second-scan-file").setInputFiles(SCAN_FILE);
    await expect(page.locator(".stances-dialog [role=alert]")).toContainText("This scan is already here");
    const { scans } = (await (await page.request.get(`${base}/api/patients/${mine.patient}`)).json()) as { scans: unknown[] };
    expect(scans).toHaveLength(1);
    expect(await page.evaluate(() => window.__breastrig!.state().scan!.info.id)).toBe(mine.id);
    await page.keyboard.press("Escape");
  });

  await test.step("an item of a scan that another tab deletes meanwhile", async () => {
    const file = { name: "scan.ply", mimeType: "application/octet-stream", buffer: readFileSync(join(EXAMPLES, "supine", "scan.ply")) };
    const added = (await (await page.request.post(`${base}/api/scans`, { multipart: { file, patient: mine.patient } })).json()) as Scan;
    const plan = await page.request.get(base + mine.links.plan);
    const { items } = (await plan.json()) as { items: unknown[] };
    expect((await page.request.delete(`${base}/api/scans/${added.id}`)).status()).toBe(204);
    const note = { kind: "note", id: "n", scan: added.id, text: "do not resect left" };
    const answer = await page.request.put(base + mine.links.plan, { data: { items: [...items, note] }, headers: { "If-Match": plan.headers().etag! } });
    expect([409, 412, 422]).toContain(answer.status());
    const kept = (await (await page.request.get(base + mine.links.plan)).json()) as { items: { id: string }[] };
    expect(kept.items.map(({ id }) => id)).not.toContain("n");
  });
  expect(troubles.filter((trouble) => !trouble.includes("409"))).toEqual([]); // the browser logs what the service would not take
});
