// Says at the very end, in a line each, which tests failed and why, also those that passed when they were tried again: of a
// machine far away often only the last lines are seen.
import type { Reporter, TestCase, TestResult } from "@playwright/test/reporter";

const CODES = new RegExp(`${String.fromCharCode(27)}\\[[0-9;]*m`, "g"); // of a terminal's colours

export default class Failures implements Reporter {
  private readonly failed: string[] = [];

  onTestEnd(test: TestCase, result: TestResult): void {
    if (result.status === "passed" || result.status === "skipped") return;
    for (const { message = "", location } of result.errors) {
      const said = message.replace(CODES, "").split("\n").map((line) => line.trim()).filter(Boolean).slice(0, 6).join(" | ").slice(0, 400);
      this.failed.push(`${test.location.file.split("/").at(-1)}, try ${result.retry + 1}, ${Math.round(result.duration / 1000)} s, line ${location?.line ?? "?"}: ${said}`);
    }
  }

  onEnd(): void {
    if (this.failed.length > 0) console.log(["", "Failed, or only passed when tried again:", ...this.failed.map((each) => `  ${each}`)].join("\n"));
  }

  printsToStdio = (): boolean => false; // the list does
}
