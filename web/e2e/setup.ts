// Before the tests: the page is built when it is older than its sources, and one real service is started.
// Afterwards both are gone.
import { execFileSync } from "node:child_process";
import { dirname, join } from "node:path";
import { findCommand, REPOSITORY, startService } from "./service";

export default async function setup(): Promise<() => Promise<void>> {
  execFileSync(join(dirname(findCommand()), "python"), [join(REPOSITORY, "server/packaging/build_page.py")], { stdio: "inherit" });
  const { base, stop } = await startService();
  process.env.BREASTRIG_E2E_BASE = base;
  return stop;
}
