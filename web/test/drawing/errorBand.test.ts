import { describe, expect, it } from "vitest";
import { ErrorIndex, errorBand, type ErrorPoints, type Skin } from "../../src/drawing/lines/errorBand";

const CELL = 0.005;

/** A flat square of skin of 0.1 m, facing +z, at the height z. */
function plate(z = 0, facing = 1): Skin {
  const side = 21;
  const position = Array.from({ length: side * side }, (_, i) => [CELL * (i % side) - 0.05, CELL * Math.floor(i / side) - 0.05, z]).flat();
  const normal = Array.from({ length: side * side }, () => [0, 0, facing]).flat();
  const index: number[] = [];
  for (let j = 0; j + 1 < side; j += 1)
    for (let i = 0; i + 1 < side; i += 1) {
      const at = j * side + i;
      index.push(at, at + 1, at + side, at + 1, at + side + 1, at + side);
    }
  return { position, normal, index };
}

/** A line along x through the middle, with an error that grows from 3 to 13 mm. */
function line(): ErrorPoints {
  const count = 41;
  const share = (i: number): number => i / (count - 1);
  return {
    points: Float32Array.from(Array.from({ length: count }, (_, i) => [0.08 * share(i) - 0.04, 0, 0]).flat()),
    normals: Float32Array.from(Array.from({ length: count }, () => [0, 0, 1]).flat()),
    errors: Float32Array.from({ length: count }, (_, i) => 0.003 + 0.01 * share(i)),
  };
}

const widthAt = (skin: Skin, x: number): number => {
  const { position, share } = errorBand(skin, new ErrorIndex(line()));
  let widest = 0;
  share.forEach((each, i) => {
    if (each < 1 && Math.abs(position[3 * i]! - x) < 0.002) widest = Math.max(widest, Math.abs(position[3 * i + 1]!));
  });
  return widest;
};

describe("the band of a line's error", () => {
  it("is as wide as the error is large, on both sides", () => {
    expect(widthAt(plate(), -0.035)).toBeGreaterThan(0.0024);
    expect(widthAt(plate(), -0.035)).toBeLessThan(0.005);
    expect(widthAt(plate(), 0.035)).toBeGreaterThan(0.011);
    expect(widthAt(plate(), 0.035)).toBeLessThan(0.0135);
  });

  it("covers each place of the skin at most once", () => {
    const { position } = errorBand(plate(), new ErrorIndex(line()));
    const middles = new Set<string>();
    for (let i = 0; i < position.length; i += 9) middles.add([0, 1].map((k) => Math.round(1e6 * (position[i + k]! + position[i + 3 + k]! + position[i + 6 + k]!))).join());
    expect(middles.size).toBe(position.length / 9);
    expect(middles.size).toBeGreaterThan(100);
  });

  it("does not reach over to skin that faces another way", () => {
    expect(errorBand(plate(0.002, -1), new ErrorIndex(line())).position).toHaveLength(0);
  });

  it("is nothing without points whose error is known", () => {
    const none = { points: new Float32Array(), normals: new Float32Array(), errors: new Float32Array() };
    expect(errorBand(plate(), new ErrorIndex(none)).position).toHaveLength(0);
  });

  it("names the point in whose error a place lies", () => {
    const index = new ErrorIndex(line());
    expect(index.nearest(0.039, 0.006, 0, 0, 0, 1)).toMatchObject({ share: expect.closeTo(6 / 13, 1) as number });
    expect(index.nearest(-0.04, 0.006, 0, 0, 0, 1)).toBeNull();
  });
});
