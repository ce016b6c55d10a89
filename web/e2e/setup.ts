// Before the tests: the page is built when it is older than its sources, the example patient is made coarse, and two real
// services are started: one for everybody, and one that asks for a token and has links.  Afterwards all are gone.
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
  const [everybodys, owners] = await Promise.all([startService(), startService({}, [])]); // with the token that it makes itself
  process.env.BREASTRIG_E2E_BASE = everybodys.base;
  process.env.BREASTRIG_E2E_OWNER = JSON.stringify({ address: owners.address, data: owners.data });
  return async () => {
    await Promise.all([everybodys.stop(), owners.stop()]);
    rmSync(folder, { recursive: true, force: true });
  };
}
