// Compressed and nested scan files: unpacked in the page, under its policy, and sent as plain triangles.
import { execFileSync } from "node:child_process";
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { expect } from "@playwright/test";
import { hook, test } from "./page";
import { findPython, helper } from "./service";

const EXAMPLE = join(process.env.BREASTRIG_E2E_EXAMPLES ?? "", "standing", "scan.ply");

test("a scan that Draco compressed is unpacked in the page, and the service is sent plain triangles", async ({ page, base, troubles }, info) => {
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
  expect(troubles).toEqual([]);

  const broken = info.outputPath("scan.usdz");
  writeFileSync(broken, readFileSync(compressed).subarray(0, 500));
  await page.goto(base);
  let sent = 0;
  page.on("request", (request) => (sent += request.method() === "POST" ? 1 : 0));
  await page.locator("#scan-file").setInputFiles(broken);
  await expect(page.getByRole("alert").filter({ hasText: "This file" })).toBeVisible();
  expect(sent).toBe(0);
  expect(troubles).toEqual([]);
});
