// Runs one of the shows in scripts/shows:  node scripts/show.mjs screenshots DIR
import { spawnSync } from "node:child_process";
import { resolve } from "node:path";

const [show, named] = process.argv.slice(2);
if (!show) throw new Error("Say which show: screenshots DIR, pictures, frames, main_job or opening.");
const folder = named ?? (show === "pictures" ? resolve(import.meta.dirname, "../../docs/pictures") : undefined);
if (show === "screenshots" && !folder) throw new Error("Say where the pictures go: npm run screenshots -- DIR");
const web = resolve(import.meta.dirname, "..");
const env = { ...process.env, ...(folder ? { BREASTRIG_SHOW_FOLDER: resolve(process.env.INIT_CWD ?? ".", folder) } : {}) };
const { status } = spawnSync("npx", ["playwright", "test", "-c", "scripts/shows/playwright.config.ts", `${show}.show.ts`], { cwd: web, env, stdio: "inherit" });
process.exit(status ?? 1);
