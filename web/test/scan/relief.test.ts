// The shading of scans without colours, on shapes whose curvature is known.
import type { BufferGeometry} from "three";
import { PlaneGeometry, SphereGeometry } from "three";
import { expect, test } from "vitest";
import { bodyOf, NOTHING_CUT } from "../../src/scan/body";
import { NO_CROPS } from "../../src/scan/crop";
import { reliefOf } from "../../src/scan/relief";

const of = (geometry: BufferGeometry): Uint8Array => reliefOf(geometry.attributes.position!.array, geometry.index!.array);
const middle = (values: Uint8Array): number => [...values].sort((a, b) => a - b)[Math.floor(values.length / 2)]!;

test("flat is 128; a ball is brighter the smaller it is, seen from within darker by as much", () => {
  expect([...new Set(of(new PlaneGeometry(0.2, 0.2, 40, 40)))]).toEqual([128]);
  const [small, large] = [of(new SphereGeometry(0.01, 32, 24)), of(new SphereGeometry(0.06, 96, 72))].map(middle) as [number, number];
  expect(small).toBeGreaterThan(235); // a nipple
  expect(large).toBeGreaterThan(150); // a breast: only a hint
  expect(large).toBeLessThan(175);
  const within = new SphereGeometry(0.01, 32, 24);
  within.setIndex([...within.index!.array].reverse());
  expect(middle(of(within))).toBe(256 - small);
});

test("a fold is darkest along its bottom, and the same on a mesh twice as fine", () => {
  const fold = (steps: number): { bottom: number; beside: number } => {
    const geometry = new PlaneGeometry(0.1, 0.1, steps, steps);
    const at = geometry.attributes.position!;
    for (let i = 0; i < at.count; i += 1) at.setZ(i, Math.min(0.02, Math.sqrt(at.getX(i) ** 2 + 0.003 ** 2))); // a valley along y, 3 mm round at its bottom
    const relief = of(geometry);
    const where = (near: number): number => middle(relief.filter((_, i) => Math.abs(Math.abs(at.getX(i)) - near) < 0.001 && Math.abs(at.getY(i)) < 0.03));
    return { bottom: where(0), beside: where(0.014) };
  };
  const [coarse, fine] = [fold(50), fold(100)];
  for (const { bottom, beside } of [coarse, fine]) {
    expect(bottom).toBeLessThan(60);
    expect(Math.abs(beside - 128)).toBeLessThan(25);
  }
  expect(Math.abs(coarse.bottom - fine.bottom)).toBeLessThan(20);
});

test("noise as of a depth camera on a plane is hardly seen", () => {
  const geometry = new PlaneGeometry(0.2, 0.2, 100, 100); // edges of 2 mm
  const at = geometry.attributes.position!;
  let state = 7;
  const random = (): number => ((state = (state * 16807) % 2147483647) / 2147483647) - 0.5;
  for (let i = 0; i < at.count; i += 1) at.setZ(i, 0.0004 * random()); // a tenth of a millimetre, after fusion
  const relief = of(geometry);
  const rms = Math.sqrt(relief.reduce((sum, value) => sum + (value - 128) ** 2, 0) / relief.length);
  expect(rms).toBeLessThan(16); // of 127
});

test("the worker adds it where it is asked to, and only there", () => {
  const ball = new SphereGeometry(0.06, 32, 24);
  const question = { positions: ball.attributes.position!.array as Float32Array, index: Uint32Array.from(ball.index!.array), isSplit: false, cut: NOTHING_CUT, crops: NO_CROPS };
  expect(bodyOf({ ...question, wantsRelief: false }).relief).toBeNull();
  expect(bodyOf({ ...question, wantsRelief: true }).relief).toHaveLength(ball.attributes.position!.count);
});
