// The same browser and service as for the tests, for what is shown instead of tested: pictures and times.
import { resolve } from "node:path";
import tests from "../../playwright.config";

export default {
  ...tests,
  testDir: import.meta.dirname,
  testMatch: "*.show.ts",
  globalSetup: resolve(import.meta.dirname, "../../e2e/setup.ts"),
  outputDir: resolve(import.meta.dirname, "../../test-results"),
  timeout: 600_000,
  use: { ...tests.use, deviceScaleFactor: 1 }, // pictures as large as the screen
};
