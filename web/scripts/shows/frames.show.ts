// How long a picture takes while a large scan is turned by hand, and how long a pick takes.  Software rendering: what a
// graphics card does in a millisecond costs the processor ten, so the figures are the worst that a user meets.
import { test } from "@playwright/test";
import { hook } from "../../e2e/page";
import { bodyOf } from "./body";

const SIZES = [100_000, 300_000];
const PICKS = 400;

const at = (sorted: readonly number[], share: number): number => sorted[Math.min(sorted.length - 1, Math.floor(share * sorted.length))]!;

for (const triangles of SIZES) {
  test(`${triangles} triangles`, async ({ page }) => {
    await page.goto(process.env.BREASTRIG_E2E_BASE!);
    const file = { name: "scan.ply", mimeType: "application/octet-stream", buffer: bodyOf(triangles) };
    await page.locator("#scan-file").setInputFiles(file);
    await hook.ready(page);
    const drawn = await page.evaluate(() => window.__breastrig!.state().scan!.info.triangles);
    const box = (await page.locator("main canvas.view").boundingBox())!;
    const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
    await page.evaluate(() => {
      const times: number[] = [];
      let before = { now: 0, frames: window.__breastrig!.frames() };
      const look = (now: number): void => {
        const frames = window.__breastrig!.frames();
        if (frames > before.frames && before.now > 0) times.push((now - before.now) / (frames - before.frames));
        before = { now, frames };
        requestAnimationFrame(look);
      };
      requestAnimationFrame(look);
      Object.defineProperty(window, "frameTimes", { value: times });
    });
    await page.mouse.move(x, y);
    await page.mouse.down();
    for (let i = 0; i < 150; i += 1) await page.mouse.move(x + 100 * Math.sin(i / 12), y + 30 * Math.sin(i / 20));
    await page.mouse.up();
    const times = (await page.evaluate(() => (window as unknown as { frameTimes: number[] }).frameTimes)).sort((a, b) => a - b);
    // The clock of a page counts tenths of a millisecond: many picks are timed together.
    const picks = await page.evaluate(
      ([left, top, width, height, count]) => {
        let hits = 0;
        const begun = performance.now();
        for (let i = 0; i < count; i += 1) {
          const at = [left + width * (0.35 + 0.3 * ((i * 0.618) % 1)), top + height * (0.25 + 0.5 * ((i * 0.414) % 1))] as const;
          if (window.__breastrig!.pickAt(...at)) hits += 1;
        }
        return { ms: (performance.now() - begun) / count, hits };
      },
      [box.x, box.y, box.width, box.height, PICKS] as const,
    );
    console.log(
      `${drawn} triangles: a picture ${at(times, 0.5).toFixed(1)} ms (median), ${at(times, 0.95).toFixed(1)} ms (95 %) of ${times.length} while turning; ` +
        `a pick ${picks.ms.toFixed(3)} ms (mean of ${PICKS}, ${picks.hits} on the body)`,
    );
  });
}
