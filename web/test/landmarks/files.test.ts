import { expect, test } from "vitest";
import { toCsv, toJson, toMeshlab, toSlicer } from "../../src/landmarks/files/writing";
import type { Picks } from "../../src/landmarks/picks";

const picks: Picks = { nipple_L: [95, 120.5, 130], "a<b&c": [-98, 118, 128] };

test("our own kind says its unit and what is certain", () => {
  expect(JSON.parse(toJson(picks, "m", []))).toEqual({ schema: "breastrig/landmarks@1", unit: "mm", landmarks: picks });
  expect(JSON.parse(toJson(picks, "m", ["nipple_L"]))).toMatchObject({ certain: ["nipple_L"] });
});

test("a table is in the scan's unit", () => {
  expect(toCsv({ nipple_L: picks.nipple_L! }, "m")).toBe("name,x,y,z\nnipple_L,0.095,0.1205,0.13\n");
});

test("MeshLab's kind is XML in the scan's unit", () => {
  expect(toMeshlab(picks, "cm")).toContain(' <point x="9.5" y="12.05" z="13" active="1" name="nipple_L"/>\n');
  expect(toMeshlab(picks, "cm")).toContain('name="a&lt;b&amp;c"/>');
});

test("3D Slicer's kind names its format, and the frame of mesh files", () => {
  const file = JSON.parse(toSlicer(picks, "m")) as { "@schema": string; markups: { coordinateSystem: string; controlPoints: { label: string; position: number[] }[] }[] };
  expect(file["@schema"]).toMatch(/markups-schema-v1\.0\.3\.json#$/);
  expect(file.markups[0]).toMatchObject({ coordinateSystem: "LPS", controlPoints: [{ label: "nipple_L", position: [0.095, 0.1205, 0.13] }, {}] });
});
