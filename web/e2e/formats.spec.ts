// Compressed and nested scan files, and landmark files of other programs: sent as they are, read by the service.
import { execFileSync } from "node:child_process";
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { expect } from "@playwright/test";
import { hook, test } from "./page";
import { findPython, helper } from "./service";

const EXAMPLE = join(process.env.BREASTRIG_E2E_EXAMPLES ?? "", "standing", "scan.ply");

test("a scan that Draco compressed is shown, a damaged USDZ is the service's sentence, and a table of landmarks is placed", async ({ page, base, troubles }, info) => {
  const compressed = info.outputPath("scan.glb");
  const { path, env } = helper("draco_scan.py");
  execFileSync(findPython(), [path, EXAMPLE, compressed], { env });
  const triangles = Number(/element face (\d+)/.exec(readFileSync(EXAMPLE, "latin1"))![1]);
  await page.goto(base);
  const asked = page.waitForRequest((request) => request.url().endsWith("/api/scans") && request.method() === "POST");
  await page.locator("#scan-file").setInputFiles(compressed);
  const answer = (await (await (await asked).response())!.json()) as { triangles: number };
  expect(answer.triangles).toBe(triangles);
  await hook.ready(page);

  const { landmarks } = JSON.parse(readFileSync(join(EXAMPLE, "..", "landmarks.json"), "utf8")) as { landmarks: Record<string, number[]> };
  const spoken = (name: string): string => name.replace("_L", " LEFT").replace("_R", " RIGHT").replaceAll("_", " ");
  const rows = Object.entries(landmarks).map(([name, place], index) => [index + 1, spoken(name), ...place.map((value) => String(value).replace(".", ","))].join(";"));
  const table = Buffer.from(`\ufeff${["id;label;pos x;pos y;pos z", ...rows].join("\r\n")}`, "utf16le");
  await page.locator("#landmark-file").setInputFiles({ name: "picks.csv", mimeType: "text/csv", buffer: table });
  await expect(page.getByText(`${rows.length} landmarks`).first()).toBeAttached();
  expect(troubles).toEqual([]);

  const broken = info.outputPath("scan.usdz");
  writeFileSync(broken, readFileSync(compressed).subarray(0, 500));
  await page.goto(base);
  await page.locator("#scan-file").setInputFiles(broken);
  await expect(page.getByRole("alert").filter({ hasText: /\.$/ })).toBeVisible();
});
