// The left breast laid on the right one, on a chest whose two sides are known.
import type { BufferGeometry} from "three";
import { PlaneGeometry } from "three";
import { MeshBVH } from "three-mesh-bvh";
import { afterEach, expect, test, vi } from "vitest";
import type { Result } from "../../src/api/types";
import { asymmetryOf, mirroredBreast } from "../../src/drawing/mirror/mirroredBreast";
import { withScan } from "../fakes";

afterEach(() => void vi.unstubAllGlobals());

/** A plate of 0.4 m with a hill on each side, so many metres high; the patient's left is +x. */
function chest(left: number, right: number): BufferGeometry {
  const plate = new PlaneGeometry(0.4, 0.4, 100, 100);
  const at = plate.attributes.position!;
  for (let i = 0; i < at.count; i += 1) {
    const [x, y] = [at.getX(i), at.getY(i)];
    const hill = (middle: number): number => Math.exp(-(((x - middle) / 0.04) ** 2 + (y / 0.04) ** 2));
    at.setZ(i, left * hill(0.1) + right * hill(-0.1));
  }
  plate.boundsTree = new MeshBVH(plate, { indirect: true });
  return plate;
}

const result = {
  scan: { unit: "mm" },
  landmarks: { nipple_L: [100, 0, 30], nipple_R: [-100, 0, 30], acromion_L: [180, 150, 0], acromion_R: [-180, 150, 0] },
  median_plane: { normal: [1, 0, 0], offset: 0 },
} as unknown as Pick<Result, "landmarks" | "median_plane" | "scan">;

test("even sides differ by nothing, and the mirrored one lies on the other, looking the same way", () => {
  const geometry = chest(0.03, 0.03);
  const made = mirroredBreast(geometry, result)!;
  expect(asymmetryOf(made).mostMm).toBeLessThan(0.01);
  const xs = made.positions.filter((_, i) => i % 3 === 0);
  expect(Math.max(...xs), "nothing of it beyond the midline").toBeLessThanOrEqual(0);
  expect(Math.min(...xs)).toBeLessThan(-0.18);
  for (let i = 0; i < made.index.length; i += 3) {
    const [a, b, c] = [0, 1, 2].map((k) => made.positions.subarray(3 * made.index[i + k]!, 3 * made.index[i + k]! + 3)) as [Float32Array, Float32Array, Float32Array];
    expect((b[0]! - a[0]!) * (c[1]! - a[1]!) - (b[1]! - a[1]!) * (c[0]! - a[0]!)).toBeGreaterThan(0); // to the front, as before
  }
});

test.each([[0.038, 0.03, 1], [0.03, 0.038, -1]])("a left of %s m on a right of %s m: %s for farther out, by as much as the hills differ", (left, right, sign) => {
  const made = mirroredBreast(chest(left, right), result)!;
  let [top, height] = [0, -Infinity];
  made.beyond.forEach((_, i) => {
    if (made.positions[3 * i + 2]! > height) [top, height] = [i, made.positions[3 * i + 2]!];
  });
  expect(made.beyond[top]! * sign).toBeGreaterThan(7.5);
  expect(made.beyond[top]! * sign).toBeLessThan(8.1);
  const { medianMm, mostMm } = asymmetryOf(made);
  expect(mostMm).toBeGreaterThan(medianMm);
  expect(mostMm).toBeLessThan(8.1);
});

test("what closes the model's openings is none of the breast", () => {
  const bare = mirroredBreast(chest(0.03, 0.03), result)!;
  const geometry = chest(0.03, 0.03);
  const own = [...geometry.index!.array];
  geometry.setIndex([...own, ...own]); // lids over the whole chest
  geometry.addGroup(0, own.length, 0);
  geometry.addGroup(own.length, own.length, 1);
  expect(mirroredBreast(geometry, result)!.index).toEqual(bare.index);
});

test("without nipples or pairs there is nothing to mirror", () => {
  const { nipple_L: _gone, ...rest } = result.landmarks;
  expect(mirroredBreast(chest(0.03, 0.03), { ...result, landmarks: rest })).toBeNull();
  expect(mirroredBreast(chest(0.03, 0.03), { ...result, median_plane: null })).toBeNull();
});

test("it is shown only when somebody asks for it", async () => {
  const { store, actions } = await withScan();
  expect(store.get().showMirror).toBe(false);
  actions.fit.showMirror(true);
  expect(store.get().showMirror).toBe(true);
});
