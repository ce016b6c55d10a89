// Before the tests: the page is built when it is older than its sources, the example patient is made coarse, and one real
// service is started.  Afterwards all are gone.
import { execFileSync } from "node:child_process";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { findPython, helper, REPOSITORY, startService } from "./service";

export default async function setup(): Promise<() => Promise<void>> {
  execFileSync(findPython(), [join(REPOSITORY, "server/packaging/build_page.py")], { stdio: "inherit" });
  const folder = mkdtempSync(join(tmpdir(), "breastrig-e2e-"));
  const examples = join(folder, "example");
  const { path, env } = helper("coarse_example.py");
  execFileSync(findPython(), [path, examples], { env, stdio: "inherit" });
  process.env.BREASTRIG_E2E_EXAMPLES = examples;
  process.env.BREASTRIG_REMEMBERED_UPLOADS = join(folder, "uploads");
  const { base, stop } = await startService();
  process.env.BREASTRIG_E2E_BASE = base;
  return async () => {
    await stop();
    rmSync(folder, { recursive: true, force: true });
  };
}
