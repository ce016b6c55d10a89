// The image in the slices: grey values along any plane, whichever way its axes lead, in one place with the skin's section.
import { Euler, Matrix4, Quaternion, SphereGeometry, Vector3 } from "three";
import { expect, test } from "vitest";
import type { Frame } from "../../src/api/types";
import { cut, LPS, type Skin, viewOf } from "../../src/drawing/slices/section";
import { PLANES } from "../../src/drawing/slices/state";
import { type Grey, greyOf, gridOf, resample, shades, USUAL } from "../../src/stances/slices/grey";

const SHAPE = [60, 40, 50] as const;
const RADIUS = 32;

/** A ball of 200 in the midst of voxels of 2 x 3 x 2.5 mm, its rim as wide as a voxel. */
function ballIn(turn: Euler): { grey: Grey; middle: Vector3 } {
  const toScan = new Matrix4().compose(new Vector3(40, -70, 900), new Quaternion().setFromEuler(turn), new Vector3(2, 3, 2.5));
  const middle = new Vector3(29.2, 19.6, 24.9).applyMatrix4(toScan);
  const values = new Uint8Array(SHAPE[0] * SHAPE[1] * SHAPE[2]);
  for (let k = 0, at = 0; k < SHAPE[2]; k += 1) for (let j = 0; j < SHAPE[1]; j += 1) for (let i = 0; i < SHAPE[0]; i += 1, at += 1) values[at] = Math.min(Math.max(100 + ((RADIUS - new Vector3(i, j, k).applyMatrix4(toScan).distanceTo(middle)) * 100) / 3, 0), 200);
  const rows = [0, 1, 2, 3].map((row) => [0, 1, 2, 3].map((column) => toScan.elements[4 * column + row]!));
  return { grey: greyOf(values.buffer, { shape: SHAPE, to_scan: rows })!, middle };
}

const STANDING: Frame = { up: [0, 1, 0], front: [0, 0, 1] };

test.each([["along the scan's axes", new Euler(0, 0, 0)], ["oblique", new Euler(0.5, -0.3, 0.8)], ["mirrored by its rows", new Euler(Math.PI, 0.1, 0)]] as const)("the skin's section lies where the grey values end, to half a voxel: %s", (_name, turn) => {
  const { grey, middle } = ballIn(turn);
  const geometry = new SphereGeometry(RADIUS, 64, 48).translate(...middle.toArray());
  const skin: Skin = { positions: geometry.attributes.position!.array, index: geometry.index!.array };
  for (const frame of [LPS, STANDING]) {
    for (const plane of PLANES) {
      const view = viewOf(plane, frame);
      const offset = middle.dot(new Vector3(...view.out)) + 9;
      const grid = gridOf(grey, view);
      const pixels = new Uint8Array(grid.wide * grid.high);
      resample(grey, view, offset, grid, pixels);
      const at = (x: number, y: number): number => pixels[Math.floor((grid.top - y) / grid.step) * grid.wide + Math.floor((x - grid.left) / grid.step)]!;
      const [outline] = cut(skin, view, offset);
      const [cx, cy] = [middle.dot(new Vector3(...view.right)), middle.dot(new Vector3(...view.up))];
      const half = grey.step / 2;
      expect(outline!.points.length).toBeGreaterThan(40);
      for (const [x, y] of outline!.points) {
        const far = Math.hypot(x - cx, y - cy);
        const moved = (mm: number): number => at(x + ((x - cx) / far) * mm, y + ((y - cy) / far) * mm);
        expect(moved(-half - grid.step / 2), `${plane} inside`).toBeGreaterThan(100);
        expect(moved(half + grid.step / 2), `${plane} outside`).toBeLessThan(100);
      }
    }
  }
});

test("each voxel is where its matrix says, and nothing is seen outside of all", () => {
  const rows = [[-2, 0, 0, 10], [0, 0, 3, -5], [0, 4, 0, 7], [0, 0, 0, 1]];
  const grey = greyOf(Uint8Array.from({ length: 24 }, (_, n) => 10 * (n + 1)).buffer, { shape: [2, 3, 4], to_scan: rows })!;
  const view = viewOf("axial", LPS);
  for (const [i, j, k] of [[0, 0, 0], [1, 2, 3], [1, 0, 2], [0, 2, 1]] as const) {
    const place = new Vector3(i, j, k).applyMatrix4(grey.toScan).toArray();
    const pixel = new Uint8Array(1);
    const [x, y] = [place[0], -place[1]]; // seen from the feet
    resample(grey, view, -place[2], { left: x - 0.5, top: y + 0.5, step: 1, wide: 1, high: 1 }, pixel);
    expect(pixel[0]).toBe(10 * (i + 2 * j + 6 * k + 1));
    for (const [dx, dz] of [[-30, 0], [0, 30]] as const) {
      resample(grey, view, -place[2] + dz, { left: x + dx - 0.5, top: y + 0.5, step: 1, wide: 1, high: 1 }, pixel);
      expect(pixel[0]).toBe(0);
    }
  }
  expect(greyOf(new ArrayBuffer(23), { shape: [2, 3, 4], to_scan: rows })).toBeNull();
});

test("window and level: as stored, and narrower around a darker grey", () => {
  const greys = (window: typeof USUAL) => [0, 60, 100, 140, 255].map((value) => shades(window)[value]! & 0xff);
  expect(greys(USUAL)).toEqual([0, 60, 100, 140, 255]);
  expect(greys({ level: 100, width: 80 })).toEqual([0, 0, 128, 255, 255]);
});
