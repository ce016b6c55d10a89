// A fit is drawn with the model that it was made with, whatever model the service has by now.
import { execFileSync } from "node:child_process";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { expect, type Page } from "@playwright/test";
import { hook, look, test, until, untilFitted, untilStill } from "./page";
import { findPython, FOREARM, startService } from "./service";

interface Made {
  readonly id: string;
  readonly links: Record<string, string>;
}

async function post(address: string, body?: object): Promise<Made> {
  const answer = await fetch(address, { method: "POST", headers: { "Content-Type": "application/json" }, ...(body ? { body: JSON.stringify(body) } : {}) });
  expect(answer.ok, address).toBe(true);
  return (await answer.json()) as Made;
}

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

test("a fit of the torso looks the same under a service whose model is a forearm, on the page and through its link", async ({ page }) => {
  test.slow(); // two services
  const folder = mkdtempSync(join(tmpdir(), "breastrig-e2e-"));
  execFileSync(findPython(), [FOREARM, join(folder, "rig")]);
  const troubles: string[] = [];
  page.on("pageerror", (error) => troubles.push(error.message));
  const seen: object[] = [];
  let shared = "";
  let at = "";
  try {
    for (const model of [null, join(folder, "rig", "forearm.glb")]) {
      const { base, stop } = await startService(model === null ? {} : { BREASTRIG_MODEL: model }, ["--no-token"], join(folder, "data"));
      try {
        if (model === null) {
          const scan = await post(`${base}/api/examples/standing`);
          const fit = await post(`${base}/api/fits`, { scan: scan.id, drawing: "lumpectomy", refine: false });
          await expect.poll(async () => ((await (await fetch(base + fit.links.self!)).json()) as { state: string }).state).toBe("done");
          at = `#scan=${scan.id}&fit=${fit.id}`;
          shared = ((await post(base + fit.links.shares!, {})) as Made & { url: string }).url;
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
      } finally {
        await stop();
      }
    }
  } finally {
    rmSync(folder, { recursive: true, force: true });
  }
  expect(troubles).toEqual([]);
  expect(seen[0]).toMatchObject({ rig: { isLost: false } });
  expect((seen[0] as { rig: { colours: number } }).rig.colours).toBeGreaterThan(100);
  expect(seen[1], "the same picture").toEqual(seen[0]);
});
