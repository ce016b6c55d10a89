// Parts of a scan that are hidden by a lasso: which triangles, that they can be neither picked nor drawn on, undone and redone,
// and that the scan itself stays whole.
import { type BufferGeometry, Matrix4, PerspectiveCamera, Ray, Vector3 } from "three";
import type { MeshBVH } from "three-mesh-bvh";
import { afterEach, expect, test, vi } from "vitest";
import { skinFrom, skinOn } from "../../src/drawing/skin";
import { viewBarShown } from "../../src/fit/state";
import { bodyOf, type BodyQuestion, NOTHING_CUT, partOf } from "../../src/scan/body";
import { type Crop, croppedFaces, cropsOf, NO_CROPS, shareWithin } from "../../src/scan/crop";
import { cropKey } from "../../src/scan/cropKeys";
import { keepCrops, keptCrops } from "../../src/scan/keptCrops";
import { half, made } from "../shapes";
import { withScan } from "../fakes";

afterEach(() => void vi.unstubAllGlobals());

/** Around what lies to the right of x (metres), as seen from the front. */
function rightOf(x: number): Crop {
  const camera = new PerspectiveCamera(30, 1, 0.05, 20);
  camera.position.set(0, 0, 1);
  camera.updateMatrixWorld();
  const toPicture = new Matrix4().multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse);
  const edge = new Vector3(x, 0, 0.05).applyMatrix4(toPicture).x; // of the plane z = 0.05
  return { toPicture: toPicture.toArray(), lasso: [[edge, -1], [1, -1], [1, 1], [edge, 1]] };
}

const question = (whole: BufferGeometry, crops: readonly Crop[]): BodyQuestion => ({
  positions: whole.attributes.position!.array as Float32Array,
  index: Uint32Array.from(whole.index!.array),
  isSplit: false,
  cut: NOTHING_CUT,
  crops,
  wantsRelief: false,
});

test("exactly the triangles whose middle lies in the lasso are hidden, however deep; none behind the eye", () => {
  const whole = made(half());
  const { positions, index } = question(whole, NO_CROPS);
  const crop = rightOf(0.03);
  const hidden = croppedFaces(positions, index, [crop]);
  let count = 0;
  hidden.forEach((is, face) => {
    const [x, , z] = [0, 1, 2].map((axis) => [0, 1, 2].reduce((sum, k) => sum + positions[3 * index[3 * face + k]! + axis]!, 0) / 3) as [number, number, number];
    // A line of sight through x = 0.03 at z = 0.05 leads from the eye at z = 1.
    expect(Boolean(is), `${x} ${z}`).toBe(x / (1 - z) > 0.03 / 0.95);
    count += is;
  });
  expect(count).toBeGreaterThan(500);
  expect(croppedFaces(positions.map((value, i) => (i % 3 === 2 ? value + 2 : value)), index, [crop]).includes(1), "behind the eye").toBe(false);
  expect(shareWithin(positions, index, crop)).toBeCloseTo(count / hidden.length, 1);
});

test("what is hidden can be neither picked nor drawn on, and the scan itself stays whole", () => {
  const whole = made(half());
  const before = whole.index!.array.slice();
  const { drawable, part } = bodyOf(question(whole, [rightOf(0.03)]));
  const body = partOf(whole, part!);
  const down = (x: number): boolean => (body.boundsTree as MeshBVH).raycastFirst(new Ray(new Vector3(x, 0, 1), new Vector3(0, 0, -1))) !== null;
  expect([down(-0.05), down(0), down(0.06)]).toEqual([true, true, false]);
  const skin = skinOn({ whole, drawable, body });
  const faceAt = (x: number): number => (whole.boundsTree as MeshBVH).raycastFirst(new Ray(new Vector3(x, 0, 1), new Vector3(0, 0, -1)))!.faceIndex!;
  const mayDraw = (x: number): boolean => skin.mayDraw({ face: faceAt(x), point: [1000 * x, 0, 90] }, [0, 0, 1000]);
  expect([mayDraw(-0.05), mayDraw(0.06)]).toEqual([true, false]);
  expect(skin.nearest([80, 0, 60]).point[0], "lines stay on what is left").toBeLessThan(35);
  expect(whole.index!.array).toEqual(before);
});

test("a lasso around everything hides nothing", () => {
  const whole = made(half());
  expect(bodyOf(question(whole, [rightOf(-0.5)])).part).toBeNull();
});

test("the pen goes by what is hidden now, not by what was", () => {
  const whole = made(half());
  const parts = (crops: readonly Crop[]) => {
    const { drawable, part } = bodyOf(question(whole, crops));
    return { whole, drawable, body: part && partOf(whole, part) };
  };
  let now = parts(NO_CROPS);
  const skin = skinFrom(() => now);
  expect(skin()!.nearest([80, 0, 60]).point[0]).toBeGreaterThan(70);
  now = parts([rightOf(0.03)]);
  expect(skin()!.nearest([80, 0, 60]).point[0]).toBeLessThan(35);
});

test("hiding is undone and redone step by step, belongs to its scan, and never reaches the service", async () => {
  const savePlan = vi.fn();
  const { store, actions } = await withScan({ savePlan });
  actions.scan.takeLasso(true);
  expect(store.get()).toMatchObject({ isCropping: true, overlay: "scan" });
  const press = (key: string, shiftKey = false) => cropKey(store.get(), { key, shiftKey } as KeyboardEvent, actions.scan);
  const count = (): number => cropsOf(store.get().scan).length;
  actions.scan.crop(rightOf(0.05));
  actions.scan.crop(rightOf(0.03));
  expect(count()).toBe(2);
  expect(viewBarShown(store.get()).hasLoose, "it can be looked at again").toBe(true);
  expect(press("z")).toBe(true);
  expect(count()).toBe(1);
  press("Z", true);
  expect(count()).toBe(2);
  actions.scan.uncrop();
  expect(count()).toBe(0);
  press("z");
  expect(count()).toBe(2);
  press("Escape");
  expect([store.get().isCropping, press("z")]).toEqual([false, false]);
  expect(savePlan).not.toHaveBeenCalled();
  await actions.scan.open("s2", null);
  expect(count()).toBe(0);
});

test("what is hidden stays so when its scan comes back and over a reload, and is forgotten with the scan", () => {
  const stored = new Map<string, string>();
  const memory = { getItem: (key: string) => stored.get(key) ?? null, setItem: (key: string, value: string) => void stored.set(key, value), removeItem: (key: string) => void stored.delete(key) };
  keepCrops(memory, "s1", [rightOf(0.05), rightOf(0.03)]);
  expect(keptCrops(memory, "s1")).toEqual([rightOf(0.05), rightOf(0.03)]);
  expect(keptCrops(memory, "s2")).toEqual([]);
  keepCrops(memory, "s1", []);
  expect(stored.size).toBe(0);
  for (const wrong of ["{", "null", "[3]", '[{"toPicture":[1],"lasso":[[0,0],[1,0],[0,1]]}]', '[{"toPicture":[null],"lasso":"x"}]']) {
    stored.set("breastrig.hidden.s1", wrong);
    expect(keptCrops(memory, "s1")).toEqual([]);
  }
  const full = { ...memory, setItem: () => { throw new Error("full"); } };
  expect(() => keepCrops(full, "s1", [rightOf(0.05)])).not.toThrow();
});

test("in another step there is no lasso; one that takes all is refused with a sentence", async () => {
  const { store, actions } = await withScan();
  actions.scan.takeLasso(true);
  actions.scan.cropRefused();
  expect(store.get().problems.scan).toContain("nothing would be left");
  actions.page.goTo("landmarks");
  expect(store.get().isCropping).toBe(false);
});
