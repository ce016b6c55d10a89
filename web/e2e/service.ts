// A real service for browser tests, on a free port with an empty data folder.
import { spawn } from "node:child_process";
import { existsSync, mkdtempSync, rmSync } from "node:fs";
import { createServer } from "node:net";
import { tmpdir } from "node:os";
import { delimiter, join, resolve } from "node:path";

export const REPOSITORY = resolve(import.meta.dirname, "../..");
const PATIENCE_MS = 60_000;

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

function freePort(): Promise<number> {
  return new Promise((done, failed) => {
    const probe = createServer().once("error", failed);
    probe.listen(0, "127.0.0.1", () => {
      const address = probe.address();
      probe.close(() => done(typeof address === "object" && address ? address.port : 0));
    });
  });
}

async function untilReady(base: string, hasEnded: () => boolean, said: () => string): Promise<void> {
  const end = Date.now() + PATIENCE_MS;
  while (Date.now() < end && !hasEnded()) {
    const answer = await fetch(`${base}/healthz`).catch(() => null);
    if (answer?.ok) return;
    await new Promise((later) => setTimeout(later, 200));
  }
  throw new Error(`The service did not start. It said:\n${said()}`);
}

export interface Running {
  readonly base: string;
  readonly data: string; // its folder
  readonly stop: () => Promise<void>;
}

/** Starts the service; `environment` is added to ours. */
export async function startService(environment: Record<string, string> = {}): Promise<Running> {
  const data = mkdtempSync(join(tmpdir(), "breastrig-e2e-"));
  const base = `http://127.0.0.1:${await freePort()}`;
  const options = ["serve", "--host", "127.0.0.1", "--port", new URL(base).port, "--data", data];
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
    rmSync(data, { recursive: true, force: true });
  };
  try {
    await untilReady(base, () => hasEnded, () => said);
  } catch (error) {
    await stop();
    throw error;
  }
  return { base, data, stop };
}
