// What a service has learned of its patients stands beside a fit; with a patient who is deleted it goes.
import { execFileSync } from "node:child_process";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { expect } from "@playwright/test";
import { hook, test, untilFitted } from "./page";
import { findPython, helper, type Running, startService } from "./service";

const data = mkdtempSync(join(tmpdir(), "breastrig-prior-"));
let service: Running;
test.use({ base: async ({}, use) => use(service.base) });
test.beforeAll(async () => {
  const { path, env } = helper("fake_women.py");
  execFileSync(findPython(), [path, data, "30"], { env });
  service = await startService({}, ["--no-token", "--learn-prior"], data);
});
test.afterAll(async () => {
  await service.stop();
  rmSync(data, { recursive: true });
});

interface Answer {
  readonly id: string;
  readonly scans: readonly { readonly id: string }[];
  readonly prior: { readonly stances: readonly unknown[] };
}

test("what was learned stands beside the fit, and goes with who is deleted", async ({ page, base, troubles }) => {
  const ask = async (path: string, method: string, body?: object): Promise<Answer> => {
    const answer = await fetch(base + path, { method, headers: { "Content-Type": "application/json" }, ...(body ? { body: JSON.stringify(body) } : {}) });
    expect(answer.ok, path).toBe(true);
    return (answer.status === 204 ? {} : await answer.json()) as Answer;
  };
  const learned = page.getByText(/Learned from standing patients: 30 \([1-9]\d* % closer\)\./);

  const [woman] = (await ask("/api/scans", "GET")).scans;
  await ask("/api/prior", "POST");
  const scan = await ask("/api/examples/standing", "POST");
  const fit = await ask("/api/fits", "POST", { scan: scan.id, refine: false });
  await page.goto(`${base}/#scan=${scan.id}&fit=${fit.id}`);
  await hook.ready(page);
  await untilFitted(page);
  await page.keyboard.press("3");
  await expect(learned).toBeVisible();
  await expect(learned).toContainText("Fitted with what 30 patients in this stance have in common.");

  await ask(`/api/scans/${woman!.id}`, "DELETE");
  await page.reload();
  await hook.ready(page);
  await page.keyboard.press("3");
  await expect(page.getByText("Fitted with what 30 patients")).toBeVisible(); // as it was made
  await expect(learned).toBeHidden();
  expect(troubles).toEqual([]);
});
