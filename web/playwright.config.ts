// Browser tests: the real service, a real Chromium, software rendering so that every machine draws alike.
// A missing Chromium is an error and never a skipped test.
import { execFileSync } from "node:child_process";
import { accessSync, constants } from "node:fs";
import { defineConfig } from "@playwright/test";

function find(names: readonly string[]): string | null {
  for (const name of names) {
    try {
      const path = execFileSync("/bin/sh", ["-c", 'command -v "$0"', name], { encoding: "utf8" }).trim();
      accessSync(path, constants.X_OK);
      return path;
    } catch {
      // try the next name
    }
  }
  return null;
}

const wish = process.env.BREASTRIG_CHROMIUM;
const chromium = find(wish ? [wish] : ["chromium", "chromium-browser", "google-chrome"]);
if (!chromium) throw new Error("The browser test needs Chromium: install it, or set BREASTRIG_CHROMIUM to its path.");

process.env.BREASTRIG_PLAIN_PAGES = "yes"; // what printed pages show is a question of other tests

export default defineConfig({
  testDir: "e2e",
  globalSetup: "./e2e/setup.ts",
  outputDir: "test-results",
  workers: 2, // files side by side at one service: half of a test is waiting for the browser's next frame or the service
  retries: 1, // a busy machine is no failure; what passes only then is called flaky at the end, and is to be mended
  forbidOnly: true,
  timeout: 600_000, // two tests share the machine, and machines differ by three times
  expect: { timeout: 120_000 },
  reporter: [["list"], ["./e2e/failures.ts"]],
  metadata: { chromium }, // for tests of what only the whole browser has
  use: {
    browserName: "chromium",
    actionTimeout: 120_000, // as long as what is expected may take
    viewport: { width: 1280, height: 720 },
    deviceScaleFactor: 0.25, // the same layout with a sixteenth of the pixels, all of which are drawn without a graphics card
    contextOptions: { reducedMotion: "reduce" }, // what moves is looked at where a file asks for it: workflow, day, basics
    screenshot: "only-on-failure",
    launchOptions: {
      // The same engine without a window's tabs and buttons, where it is installed: a fifth less work.
      executablePath: find(["chromium-headless-shell"]) ?? chromium,
      // Pages live for seconds: what V8's last optimiser works for is not earned back, a quarter of what a page takes.
      // The canvas alone goes through the stand-in for a graphics card: with all of the page a test takes a third longer.
      args: ["--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--no-sandbox", "--disable-background-networking", "--disable-gpu-compositing", "--js-flags=--no-opt"],
    },
  },
});
