// Parts of a scan that are cut away by a lasso: which triangles, that they can be neither picked nor drawn on, undone, redone and
// kept with the scan, which itself stays whole.
import { BufferAttribute, BufferGeometry, Matrix4, PerspectiveCamera, Ray, Vector3 } from "three";
import { MeshBVH } from "three-mesh-bvh";
import { afterEach, expect, test, vi } from "vitest";
import { skinFrom, skinOf } from "../../src/drawing/lines/skin";
import { viewBarShown } from "../../src/fit/state";
import { type Crop, croppedFaces, cropsFrom, cropsOf, cutsOf, leftOver, MOST, NO_CROPS, shareWithin, triangles } from "../../src/scan/crop";
import type { Cut } from "../../src/api/types";
import { ApiError } from "../../src/api/client";
import { outdated } from "../../src/fit/outdated";
import example from "../../../tests/scan/hand_cuts.json";
import { cropKey } from "../../src/scan/cropKeys";
import { hasLoose } from "../../src/scan/state";
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

const positionsOf = (whole: BufferGeometry): Float32Array => whole.attributes.position!.array as Float32Array;
const indexOf = (whole: BufferGeometry): Uint32Array => Uint32Array.from(whole.index!.array);

/** What is left of it, as it is seen and drawn on. */
function left(whole: BufferGeometry, crops: readonly Crop[]): BufferGeometry {
  const made = new BufferGeometry().setAttribute("position", whole.attributes.position!);
  made.setIndex(new BufferAttribute(leftOver(positionsOf(whole), indexOf(whole), crops), 1));
  made.boundsTree = new MeshBVH(made, { indirect: true });
  return made;
}

test("exactly the triangles whose middle lies in the lasso are hidden, however deep; none behind the eye", () => {
  const whole = made(half());
  const [positions, index] = [positionsOf(whole), indexOf(whole)];
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
  const body = left(whole, [rightOf(0.03)]);
  const down = (x: number): boolean => (body.boundsTree as MeshBVH).raycastFirst(new Ray(new Vector3(x, 0, 1), new Vector3(0, 0, -1))) !== null;
  expect([down(-0.05), down(0), down(0.06)]).toEqual([true, true, false]);
  expect(skinOf(body).nearest([80, 0, 60]).point[0], "lines stay on what is left").toBeLessThan(35);
  expect(whole.index!.array).toEqual(before);
});

test("a lasso around everything hides nothing", () => {
  const whole = made(half());
  expect(leftOver(positionsOf(whole), indexOf(whole), [rightOf(-0.5)])).toEqual(indexOf(whole));
});

test("the pen goes by what is hidden now, not by what was, and waits until it is known", () => {
  const whole = made(half());
  let now: BufferGeometry | null = null;
  const skin = skinFrom(() => now);
  expect(skin()).toBeNull();
  now = left(whole, NO_CROPS);
  expect(skin()!.nearest([80, 0, 60]).point[0]).toBeGreaterThan(70);
  now = left(whole, [rightOf(0.03)]);
  expect(skin()!.nearest([80, 0, 60]).point[0]).toBeLessThan(35);
});

test("the corners of chosen triangles", () => {
  const index = Uint32Array.from([0, 1, 2, 2, 1, 3, 3, 1, 4]);
  expect([...triangles(index, Uint8Array.from([1, 0, 1]), true)]).toEqual([0, 1, 2, 3, 1, 4]);
  expect([...triangles(index, Uint8Array.from([1, 0, 1]), false)]).toEqual([2, 1, 3]);
});

test("loose pieces are hidden until somebody asks for them, and can be where the service has found any", async () => {
  const { store, actions } = await withScan();
  expect(store.get().showLoose).toBe(false);
  const scan = store.get().scan!;
  const of = (more: object): boolean => hasLoose({ ...scan, info: { ...scan.info, triangles: 9, ...more } });
  expect([of({}), of({ body_triangles: 9 }), of({ body_triangles: 8 })]).toEqual([false, false, true]);
  actions.scan.showLoose(true);
  expect(store.get().showLoose).toBe(true);
});

test("cuts are undone and redone step by step, brought back one by one, and the service keeps what is seen", async () => {
  const { store, actions, client } = await withScan();
  const kept = (): Crop[] => cropsFrom(vi.mocked(client.saveCuts).mock.lastCall![1]) as Crop[];
  const settled = () => vi.waitFor(() => expect(store.get().scan!.cuts).not.toBeNull());
  actions.scan.takeLasso(true);
  expect(store.get()).toMatchObject({ isCropping: true, overlay: "scan" });
  const press = (key: string, shiftKey = false) => cropKey(store.get(), { key, shiftKey } as KeyboardEvent, actions.scan);
  const crops = () => cropsOf(store.get().scan);
  const [one, two, three] = [rightOf(0.05), rightOf(0.03), rightOf(0.01)];
  actions.scan.crop(one);
  expect(store.get().scan!.cuts, "not told yet").toBeNull();
  await settled();
  expect(kept()).toEqual([one]);
  actions.scan.crop(two);
  expect(viewBarShown(store.get()).looks.loose, "it can be looked at again").toBe(false);
  expect(press("z")).toBe(true);
  expect(crops()).toEqual([one]);
  press("Z", true);
  actions.scan.crop(three);
  actions.scan.pointAtCut(1);
  expect(store.get().pointedCut).toBe(1);
  actions.scan.bringBack(1);
  expect(store.get().pointedCut).toBeNull();
  expect(crops()).toEqual([one, three]);
  await settled();
  expect(kept()).toEqual([one, three]);
  actions.scan.uncrop();
  await settled();
  expect([crops(), store.get().scan!.cuts]).toEqual([[], ""]);
  expect(vi.mocked(client.saveCuts).mock.lastCall![1]).toEqual([]);
  press("z");
  expect(crops()).toHaveLength(2);
  press("Escape");
  expect([store.get().isCropping, press("z")]).toEqual([false, false]);
  await actions.scan.open("s2", null);
  expect(crops()).toEqual([]);
});

test("a scan comes back as it was cut, and its proposals are looked for anew after a cut", async () => {
  const cuts = async () => ({ cuts: cutsOf([rightOf(0.05)]), digest: "kept" });
  const { store, actions } = await withScan({ cuts });
  expect(cropsOf(store.get().scan)).toEqual([rightOf(0.05)]);
  expect(store.get().scan!.cuts).toBe("kept");
  store.set({ proposals: { state: "none", reason: "" } });
  actions.scan.crop(rightOf(0.03));
  await vi.waitFor(() => expect(store.get().proposals).toBeNull());
});

test("what two tabs cut is cut in both: nothing of the other's is undone, and what was brought back here stays so", async () => {
  const [old, here, there] = [rightOf(0.05), rightOf(0.03), rightOf(0.01)];
  let kept = { cuts: cutsOf([old]), digest: "first" };
  const saveCuts = vi.fn(async (_scan: unknown, cuts: readonly Cut[], seen: string) => {
    if (seen !== kept.digest) throw new ApiError("Somebody has changed these cuts.", 412);
    return (kept = { cuts: [...cuts], digest: `${cuts.length} cuts` });
  });
  const { store, actions } = await withScan({ cuts: async () => kept, saveCuts });
  kept = { cuts: cutsOf([old, there]), digest: "of the other tab" };
  actions.scan.bringBack(0);
  actions.scan.crop(here);
  await vi.waitFor(() => expect(store.get().scan!.cuts).toBe("2 cuts"));
  expect(cropsFrom(kept.cuts)).toEqual([there, here]);
  expect(cropsOf(store.get().scan)).toEqual([there, here]);
  expect(store.get().announcement).toContain("Another tab");
  expect(store.get().problems.scan ?? null).toBeNull();
});

test("what the service could not keep is said, and stays in view; more than it takes are not cut", async () => {
  const saveCuts = vi.fn(() => Promise.reject(new ApiError("No room.", 507)));
  const { store, actions } = await withScan({ saveCuts });
  actions.scan.crop(rightOf(0.05));
  await vi.waitFor(() => expect(store.get().problems.scan).toContain("No room."));
  expect(cropsOf(store.get().scan)).toHaveLength(1);
  for (let i = 0; i < MOST.cuts; i += 1) actions.scan.crop(rightOf(0.05));
  expect(cropsOf(store.get().scan)).toHaveLength(MOST.cuts);
  expect(store.get().problems.scan).toContain(String(MOST.cuts));
});

test("a fit from before a cut says so, until what was cut is brought back", async () => {
  const { store, actions } = await withScan();
  await actions.fit.start();
  expect([store.get().fit!.cuts, outdated(store.get())]).toEqual(["", null]);
  actions.scan.crop(rightOf(0.05));
  await vi.waitFor(() => expect(outdated(store.get())).toBe("cuts"));
  actions.scan.undoCrop();
  await vi.waitFor(() => expect(store.get().scan!.cuts).toBe(""));
  expect(outdated(store.get())).toBeNull();
});

test("page and service find the same triangles", () => {
  const { positions, index, cuts, cut } = example;
  const found = croppedFaces(new Float32Array(positions), index, cropsFrom(cuts as Cut[]));
  expect([...found.keys()].filter((face) => found[face])).toEqual(cut);
});

test("in another step there is no lasso; one that takes all is refused with a sentence", async () => {
  const { store, actions } = await withScan();
  actions.scan.takeLasso(true);
  actions.scan.cropRefused();
  expect(store.get().problems.scan).toContain("nothing would be left");
  actions.page.goTo("points");
  expect(store.get().isCropping).toBe(false);
});
