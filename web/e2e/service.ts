// A real service for browser tests, on a free port with an empty data folder.
import { spawn } from "node:child_process";
import { existsSync, mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { delimiter, join, resolve } from "node:path";

export const REPOSITORY = resolve(import.meta.dirname, "../..");
const PATIENCE_MS = 180_000; // a busy machine

/** The Python of the environment that has breastrig: of the one that runs us, else of the checkout's own. */
export function findPython(): string {
  const folders = [...(process.env.PATH ?? "").split(delimiter), join(REPOSITORY, ".venv", "bin")];
  const found = folders.find((folder) => existsSync(join(folder, "breastrig")));
  if (!found) throw new Error("The browser test needs the breastrig command: run `make test`, which installs it.");
  return join(found, "python");
}

/** A program of tests/helpers: its path, and the environment in which it finds the others. */
export function helper(name: string): { path: string; env: NodeJS.ProcessEnv } {
  const tests = join(REPOSITORY, "tests");
  const places = [tests, process.env.PYTHONPATH].filter(Boolean).join(delimiter);
  return { path: join(tests, "helpers", name), env: { ...process.env, PYTHONPATH: places } };
}

/** The address that the service prints when it is ready. */
async function untilReady(hasEnded: () => boolean, said: () => string): Promise<string> {
  const end = Date.now() + PATIENCE_MS;
  while (Date.now() < end && !hasEnded()) {
    const printed = /BreastRig is ready: (\S+)/.exec(said())?.[1];
    if (printed) return printed;
    await new Promise((later) => setTimeout(later, 50));
  }
  throw new Error(`The service did not start. It said:\n${said()}`);
}

export interface Running {
  readonly base: string; // without a slash at its end
  readonly address: string; // as it is printed: with the token where one was made
  readonly data: string; // its folder
  readonly stop: () => Promise<void>;
}

/** Starts the service, without a token unless `environment`, which is added to ours, or `access` says so; in a `folder` that stays and at a `port`, where they are given. */
export async function startService(environment: Record<string, string> = {}, access = "BREASTRIG_TOKEN" in environment ? [] : ["--no-token"], folder?: string, port = "0"): Promise<Running> {
  const data = folder ?? mkdtempSync(join(tmpdir(), "breastrig-e2e-"));
  const options = ["serve", "--port", port, "--data", data, ...access];
  const { path, env } = helper("serve_browser_tests.py");
  const service = spawn(findPython(), [path, ...options], { env: { ...env, ...environment } });
  let said = "";
  let hasEnded = false;
  for (const stream of [service.stdout, service.stderr]) stream.on("data", (chunk: Buffer) => (said += chunk.toString()));
  const ended = new Promise<void>((done) => {
    const end = (last = ""): void => {
      said += last;
      hasEnded = true;
      done();
    };
    service.once("error", (error) => end(error.message));
    service.once("exit", () => end());
  });
  const stop = async (): Promise<void> => {
    service.kill("SIGTERM");
    await ended;
    if (folder === undefined) rmSync(data, { recursive: true, force: true });
  };
  try {
    const address = await untilReady(() => hasEnded, () => said);
    return { base: new URL(address).origin, address, data, stop };
  } catch (error) {
    await stop();
    throw error;
  }
}
