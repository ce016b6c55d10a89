// The wrong woman's day: another patient's drawing, the same file twice, an item of a scan that is gone, another's scan.
import { expect, type Page } from "@playwright/test";
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import type { Fit } from "../src/api/types";
import { hook, SCAN_FILE, test, trueLandmarks } from "./page";
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
    await page.keyboard.press("3");
    const landmarks = JSON.parse(readFileSync(join(EXAMPLES, "standing", "landmarks.json"), "utf8")) as { unit?: string; landmarks: Record<string, [number, number, number]> };
    const { xiphoid, mid_sternum } = landmarks.landmarks;
    const shapes = [{ name: "hers", closed: false, points: [xiphoid, mid_sternum] }];
    const file = info.outputPath("another.json");
    writeFileSync(file, JSON.stringify({ schema: "breastrig/drawing@1", unit: landmarks.unit ?? "mm", patient: "P-9", scan_sha256: "ab".repeat(32), shapes }));
    await page.locator("#drawing-file").setInputFiles(file);
    const dialog = page.locator(".doubt-card");
    await expect(dialog).toContainText("patient P-9");
    await expect(dialog).toContainText(mine.patient_code);
    expect(await names()).toEqual([]);
    await dialog.getByRole("button", { name: "Do not import" }).click();
    await expect(dialog).toBeHidden();
    expect(await names()).toEqual([]);
    await page.locator("#drawing-file").setInputFiles(file);
    await dialog.getByRole("button", { name: /^Import/ }).click();
    await expect.poll(names).toEqual(["hers"]);
    await expect(page.locator(".top-bar .saved")).toHaveText("Saved");
  });

  await test.step("the same file as the other stance", async () => {
    await page.locator("#add-scan").click();
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

/** The example's supine scan of a body that is larger by this factor: another woman's. */
function anotherWoman(factor: number): Buffer {
  const file = readFileSync(join(EXAMPLES, "supine", "scan.ply"));
  const start = file.indexOf("end_header\n") + "end_header\n".length;
  const header = file.toString("latin1", 0, start);
  expect(header).toMatch(/format binary_little_endian[^]*float x\nproperty float y\nproperty float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha\nelement face/);
  const stride = 3 * 4 + 4;
  for (let vertex = 0; vertex < Number(/element vertex (\d+)/.exec(header)![1]); vertex += 1) {
    for (let at = start + stride * vertex, axis = 0; axis < 3; axis += 1) file.writeFloatLE(factor * file.readFloatLE(at + 4 * axis), at + 4 * axis);
  }
  return file;
}

/** Standing, with a line, and the scan as the other stance; both fitted without a pick.  The page is opened on the second. */
async function withSecond(page: Page, base: string, second: Buffer): Promise<Scan> {
  const send = async <Body>(method: "post" | "put", path: string, options: object): Promise<Body> => {
    const answer = await page.request[method](base + path, options);
    expect(answer.ok()).toBe(true);
    return (await answer.json()) as Body;
  };
  const brought = (buffer: Buffer, patient: object = {}) => send<Scan>("post", "/api/scans", { multipart: { file: { name: "scan.ply", mimeType: "application/octet-stream", buffer }, ...patient } });
  const fitted = async ({ id: scan }: Scan): Promise<string> => {
    const { id } = await send<Fit>("post", "/api/fits", { data: { scan } });
    await expect.poll(async () => ((await (await page.request.get(`${base}/api/fits/${id}`)).json()) as Fit).state).toBe("done");
    return id;
  };
  const mine = await brought(readFileSync(join(EXAMPLES, "standing", "scan.ply")));
  const { xiphoid, mid_sternum } = trueLandmarks();
  await send("put", `/api/scans/${mine.id}/drawing`, { data: { schema: "breastrig/drawing@1", unit: "mm", shapes: [{ name: "incision", closed: false, color: "#101010", points: [xiphoid, mid_sternum] }] } });
  const own = await fitted(mine);
  const other = await brought(second, { patient: mine.patient });
  const its = await fitted(other);
  await page.goto("about:blank");
  await page.goto(`${base}/#scan=${other.id}&fit=${its}&step=body&other=${mine.id}&otherfit=${own}&second=1`);
  return mine;
}

const carried = (page: Page): Promise<string[]> => page.evaluate(() => (window.__breastrig!.state().drawn.onScan?.carried.shapes ?? []).map(({ name }) => name));

test("another woman's scan as the other stance is asked about, without a pick", async ({ page, base, troubles }, info) => {
  const anothers = anotherWoman(1.2);
  const dialog = page.locator(".doubt-card");
  const patientOf = async (scan: string): Promise<string> => ((await (await page.request.get(`${base}/api/scans/${scan}`)).json()) as Scan).patient;
  const openScan = () => page.evaluate(() => window.__breastrig!.state().scan!.info.id);

  await test.step("it has to be answered, and says why", async () => {
    const mine = await withSecond(page, base, anothers);
    await expect(dialog).toContainText("do not look like scans of one patient");
    await expect(dialog).toContainText(mine.patient_code);
    await page.keyboard.press("Escape");
    await expect(dialog).toBeVisible();
    await page.screenshot({ path: info.outputPath("asked.png") });
    expect(await carried(page)).toEqual([]);
    const second = await openScan();
    expect(await patientOf(second)).toBe(mine.patient);
    await page.reload();
    await expect(dialog).toBeVisible();
    await page.waitForLoadState("networkidle"); // what is asked of a fit while its scan moves is answered by 404

    await dialog.getByRole("button", { name: /another patient/ }).click();
    await expect(dialog).toBeHidden();
    await expect.poll(openScan).toBe(mine.id);
    expect(await page.evaluate(() => window.__breastrig!.state().stances.other)).toBeNull();
    expect(await patientOf(second)).not.toBe(mine.patient);
    expect(await carried(page)).toEqual([]);
  });

  await test.step("who says that it is the same patient is not asked again", async () => {
    await withSecond(page, base, anothers);
    await expect(dialog).toBeVisible();
    expect(await carried(page)).toEqual([]);
    await expect(page.locator("#side-body"), "the question has the panel's place").toBeHidden();
    await dialog.getByRole("button", { name: "I cannot say" }).click();
    await expect(dialog).toBeHidden();
    await page.keyboard.press("3");
    await expect(page.locator(".carry")).toContainText("it is open whether both are this patient's");
    expect(await carried(page)).toEqual([]);
    await page.getByRole("button", { name: "Say whose scans they are" }).click();
    await dialog.getByRole("button", { name: /^Yes/ }).click();
    await expect(dialog).toBeHidden();
    await expect.poll(() => carried(page)).toEqual(["incision"]);
    await page.keyboard.press("1");
    await expect(page.locator("#side-body")).toBeVisible();
    await page.reload();
    await hook.ready(page);
    await expect.poll(() => carried(page)).toEqual(["incision"]);
    await expect(dialog).toBeHidden();
  });
  expect(troubles).toEqual([]);
});
