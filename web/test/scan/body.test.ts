// The patient apart from the table and the loose pieces of her scan: what is shown, picked, framed; nothing is lost.
import { type BufferGeometry, Matrix4, Mesh, MeshBasicMaterial, PlaneGeometry, Raycaster, SphereGeometry, Vector3 } from "three";
import { acceleratedRaycast } from "three-mesh-bvh";
import { expect, test } from "vitest";
import type { Scan, Vector } from "../../src/api/types";
import { type Body, type BodyQuestion, bodyOf, type CutByService, cutByService, indexOf, NOTHING_CUT, partOf } from "../../src/scan/body";
import { borderEdges } from "../../src/scan/borders";
import { NO_CROPS } from "../../src/scan/crop";
import { withLoose } from "../../src/scan/state";
import { extent } from "../../src/viewer/extent";
import { withScan } from "../fakes";
import { half, made, onTable, place } from "../shapes";

const question = (whole: BufferGeometry, cut: CutByService): BodyQuestion => ({
  positions: whole.attributes.position!.array as Float32Array,
  index: Uint32Array.from(whole.index!.array),
  isSplit: false,
  cut,
  crops: NO_CROPS,
  wantsRelief: false,
});

const asGuessed = (normal: Vector | null): CutByService => ({ ...NOTHING_CUT, table: normal && { normal, height: null } });

/** As the worker hands it over. */
const found = (whole: BufferGeometry, tableNormal: Vector | null): Body => structuredClone(bodyOf(question(whole, asGuessed(tableNormal))));

function below(geometry: BufferGeometry, x: number, y: number): { point: Vector3; face: number } | null {
  const mesh = new Mesh(geometry, new MeshBasicMaterial());
  mesh.raycast = acceleratedRaycast;
  const ray = new Raycaster(new Vector3(x, y, 1), new Vector3(0, 0, -1));
  ray.firstHitOnly = true;
  const hit = ray.intersectObject(mesh, false)[0];
  return hit ? { point: hit.point, face: hit.faceIndex! } : null;
}

test("the body alone has exactly the triangles that are skin, and each knows which one of the scan it is", () => {
  const whole = onTable();
  const { drawable, part } = found(whole, [0, 0, 1]);
  expect(part!.faces).toEqual(Uint32Array.from({ length: half().index!.count / 3 }, (_, face) => face));
  expect(part!.faces).toHaveLength(drawable.count);
  const index = whole.index!.array;
  part!.faces.forEach((face, i) => expect([...part!.index.subarray(3 * i, 3 * i + 3)]).toEqual([...index.slice(3 * face, 3 * face + 3)]));
});

test("hidden pieces cannot be picked, the body can, at the same place as before", () => {
  const whole = onTable();
  const body = partOf(whole, found(whole, [0, 0, 1]).part!);
  expect(below(whole, 0.25, 0), "the table is there").not.toBeNull();
  expect(below(body, 0.25, 0)).toBeNull();
  expect(below(whole, 0.2, 0.2), "the ball beside her is there").not.toBeNull();
  expect(below(body, 0.2, 0.2)).toBeNull();
  const [before, now] = [below(whole, 0.03, 0.02)!, below(body, 0.03, 0.02)!];
  expect(now.point.distanceTo(before.point)).toBeLessThan(1e-9);
  expect(now.face).toBe(before.face); // the ball comes first in this scan
});

test("a floor or wall that the service has cut away is no skin, however large, and nothing behind it is", () => {
  const wall = place(new PlaneGeometry(2, 2, 40, 40), 0, 0, -0.3);
  const behind = place(new SphereGeometry(0.2, 32, 32), 0, 0, -0.8);
  const whole = made(half(), wall, behind);
  const hers = half().index!.count / 3;
  const { drawable, part } = bodyOf(question(whole, { ...NOTHING_CUT, background: [{ normal: [0, 0, 1], height_m: -0.3 }] }));
  expect(part!.faces).toEqual(Uint32Array.from({ length: hers }, (_, face) => face));
  expect(drawable.isSkin.slice(hers).every((is) => is === 0)).toBe(true);
  expect(found(whole, null).drawable.isSkin[0], "else she is the loose piece").toBe(0);
});

test("the scan itself stays whole", () => {
  const whole = onTable();
  const [positions, index] = [whole.attributes.position!.array.slice(), whole.index!.array.slice()];
  const body = partOf(whole, found(whole, [0, 0, 1]).part!);
  expect(whole.attributes.position!.array).toEqual(positions);
  expect(whole.index!.array).toEqual(index);
  expect(body.attributes.position, "no vertex is held twice").toBe(whole.attributes.position);
});

test("what is hidden does not count for the picture's frame", () => {
  const whole = onTable();
  const positions = whole.attributes.position!.array;
  const { part } = found(whole, [0, 0, 1]);
  const width = (used: ArrayLike<number> | null): number => extent(positions, new Matrix4(), used).getSize(new Vector3()).x;
  expect(width(null)).toBeGreaterThan(0.5);
  expect(width(part!.index)).toBeGreaterThan(0.19);
  expect(width(part!.index)).toBeLessThanOrEqual(0.2 + 1e-6);
});

test("the rims are those of the body alone", () => {
  const whole = onTable();
  const { part } = found(whole, [0, 0, 1]);
  const alone = half();
  expect(part!.rims).toEqual(borderEdges(alone.attributes.position!.array, alone.index!.array, false));
});

test("a scan of nothing but the patient is left as it is", () => {
  const body = found(made(new SphereGeometry(0.1, 32, 24)), null);
  expect(body.part).toBeNull();
  expect(body.drawable.count).toBe(body.drawable.isSkin.length);
});

test("the table is where the service says, else where a patient who lies faces", () => {
  const frame = { up: [0, 1, 0], front: [0, 0, 1] };
  const lying = { stance: { proposed: "supine" }, frame } as unknown as Scan;
  expect(cutByService({ ...lying, table: { normal: [0, 0.6, 0.8], height_m: -0.2 } }).table).toEqual({ normal: [0, 0.6, 0.8], height: -0.2 });
  expect(cutByService(lying).table).toEqual({ normal: [0, 0, 1], height: null });
  expect(cutByService({ ...lying, stance: { proposed: "standing" } } as unknown as Scan)).toEqual(NOTHING_CUT);
});

test("a table is hidden by the service's plane where the body's front is off", () => {
  const [whole, hers] = [onTable(), half().index!.count / 3];
  const front: Vector = [Math.sin(0.4), 0, Math.cos(0.4)];
  const left = (cut: CutByService): number => bodyOf(question(whole, cut)).drawable.count - hers;
  expect(left(asGuessed(front)), "the guess takes her for the scrap").not.toBe(0);
  expect(left({ ...NOTHING_CUT, table: { normal: [0, 0, 1], height: 0 } })).toBe(0);
});

test("the corners of chosen triangles", () => {
  expect([...indexOf([0, 1, 2, 2, 1, 3, 3, 1, 4], Uint8Array.from([1, 0, 1]))]).toEqual([0, 1, 2, 3, 1, 4]);
});

test("a piece that the service has cut away is hidden, however large; her own never is", () => {
  const hand = place(new SphereGeometry(0.06, 32, 32), 0.3, 0, 0.1);
  const whole = made(half(), hand);
  const hers = half().index!.count / 3;
  const cut = (others: Vector[]) => bodyOf(question(whole, { ...NOTHING_CUT, others })).drawable.isSkin;
  expect(cut([]).every((is) => is === 1)).toBe(true);
  const isSkin = cut([[0.3, 0.02, 0.15]]);
  expect(isSkin.slice(0, hers).every((is) => is === 1)).toBe(true);
  expect(isSkin.slice(hers).some((is) => is === 1)).toBe(false);
  expect(cut([[0, 0, 0.1]]).every((is) => is === 1)).toBe(true);
});

test("loose pieces are hidden until somebody asks for them, and what was found belongs to its own scan", async () => {
  const { store, actions } = await withScan();
  expect(store.get().showLoose).toBe(false);
  const file = store.get().scan!.mesh!;
  expect(withLoose(store.get(), file).scan?.hasLoose).toBe(true);
  expect(withLoose(store.get(), new ArrayBuffer(1)).scan).toBe(store.get().scan);
  actions.scan.showLoose(true);
  expect(store.get().showLoose).toBe(true);
});
