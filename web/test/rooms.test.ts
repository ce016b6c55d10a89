// The dependency rule itself: does .dependency-cruiser.js forbid what it is there to forbid, and know every room?
import { readdirSync, readFileSync } from "node:fs";
import { expect, test } from "vitest";

interface Side {
  path?: string;
  pathNot?: string;
  circular?: boolean;
}

const read = (name: string): URL => new URL(`../${name}`, import.meta.url);
const { default: config } = (await import(read(".dependency-cruiser.js").href)) as { default: { forbidden: { name: string; from: Side; to: Side }[] } };

const rooms = config.forbidden.flatMap(({ name }) => /^(\w+)-knows-no-room-above$/.exec(name)?.[1] ?? []);
const top = "app";

function isForbidden(from: string, to: string): boolean {
  const fits = ({ path, pathNot }: Side, file: string): boolean => path !== undefined && new RegExp(path).test(file) && !(pathNot !== undefined && new RegExp(pathNot).test(file));
  return config.forbidden.some((rule) => fits(rule.from, from) && fits(rule.to, to));
}

test("each folder of the page is a room in the list", () => {
  const folders = readdirSync(read("src"), { withFileTypes: true }).filter((entry) => entry.isDirectory());
  expect([...rooms, top].sort()).toEqual(folders.map(({ name }) => name).sort());
});

test("a room may import those before it and none after it", () => {
  const all = [...rooms, top];
  for (const [a, from] of all.entries()) {
    for (const [b, to] of all.entries()) {
      expect(isForbidden(`src/${from}/file.ts`, `src/${to}/deeper/file.ts`), `${from} -> ${to}`).toBe(b > a);
    }
  }
});

test("circles, and three.js in panels and state, are forbidden", () => {
  expect(config.forbidden.some(({ to }) => to.circular)).toBe(true);
  const three = "node_modules/three/build/three.module.js";
  for (const file of ["src/fit/NumbersPanel.ts", "src/share/ShareDialog.ts", "src/landmarks/GuideCard.ts", "src/scan/state.ts", "src/ui/dom.ts", "src/app/Page.ts"]) {
    expect(isForbidden(file, three), file).toBe(true);
  }
  for (const file of ["src/viewer/Viewer.ts", "src/fit/TorsoModel.ts", "src/drawing/skin.ts"]) expect(isForbidden(file, three), file).toBe(false);
});

test("the map of the rooms names them in the same order", () => {
  const map = [...readFileSync(read("README.md"), "utf8").matchAll(/^\| `(\w+)\/` \|/gm)].map(([, room]) => room);
  expect(map).toEqual([...rooms, top]);
});
