// The projector's matrix against cameras that are known: exact clicks, clicks that are off, and sets that fix no matrix.
import { readFileSync } from "node:fs";
import { describe, expect, test } from "vitest";
import type { LandmarkFile, Vector } from "../../src/api/types";
import { besideSight, type Camera, eyeOf, handedness, parallelCamera, project, towardsEye } from "../../src/projector/camera";
import { projectionThrough, type Projection, type Refusal, type Sighting } from "../../src/projector/dlt";
import { symmetricEigen } from "../../src/projector/eigen";
import { cross, dot } from "../../src/viewer/frame";
import { mmFrom } from "../../src/ui/units";
import { seeded } from "../seeded";

const normal = (random: () => number): number => Math.sqrt(-2 * Math.log(1 - random())) * Math.cos(2 * Math.PI * random());

/** Looks from `eye` to `target`; pixels of `focal`, the middle of the picture at (960, 540). */
function cameraAt(eye: Vector, target: Vector, focal = 2000): Camera {
  const minus = (a: Vector, b: Vector): Vector => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
  const unit = (v: Vector): Vector => v.map((value) => value / Math.hypot(...v)) as Vector;
  const away = unit(minus(target, eye));
  const right = unit(cross(away, [0, 1, 0]));
  const down = cross(away, right);
  const rows = [right, down, away].map((axis) => [...axis, -dot(axis, eye)]);
  return [...rows[0]!.map((value, k) => focal * value + 960 * rows[2]![k]!), ...rows[1]!.map((value, k) => focal * value + 540 * rows[2]![k]!), ...rows[2]!];
}

const EXAMPLE = JSON.parse(readFileSync(new URL("../../../model_assets/example/standing/landmarks.json", import.meta.url), "utf8")) as LandmarkFile;
const LANDMARKS = Object.values(EXAMPLE.landmarks).map((point) => point.map((value) => mmFrom(value, EXAMPLE.unit ?? "mm")) as Vector);
const MIDDLE = [0, 1, 2].map((axis) => LANDMARKS.reduce((sum, point) => sum + point[axis]!, 0) / LANDMARKS.length) as Vector;
const from = (x: number, y: number, z: number): Vector => [MIDDLE[0] + x, MIDDLE[1] + y, MIDDLE[2] + z];

const seenBy = (camera: Camera, points: readonly Vector[], off: () => number = () => 0): Sighting[] =>
  points.map((point) => {
    const { at } = project(camera, point);
    return { point, at: [at[0] + off(), at[1] + off()] };
  });

function solved(found: Projection | Refusal): Projection {
  if (typeof found === "string") throw new Error(found);
  return found;
}

describe("a known projector", () => {
  const eyes = [from(0, 0, 1500), from(700, 300, 1300), from(-500, 900, 1100)];

  test.each(eyes)("is found from exact clicks on the example's landmarks, to a thousandth of a pixel", (...eye) => {
    const camera = cameraAt(eye, MIDDLE);
    const found = solved(projectionThrough(seenBy(camera, LANDMARKS)));
    const random = seeded(1);
    for (let i = 0; i < 50; i += 1) {
      const point = from(400 * (random() - 0.5), 400 * (random() - 0.5), 200 * (random() - 0.5));
      const [a, b] = [project(found.camera, point).at, project(camera, point).at];
      expect(Math.hypot(a[0] - b[0], a[1] - b[1])).toBeLessThan(1e-3);
    }
    expect(found.rmsPixels).toBeLessThan(1e-6);
    expect(Math.hypot(...eyeOf(found.camera)!.map((value, k) => value - (eye)[k]!))).toBeLessThan(0.01);
  });

  test("with clicks one pixel off, lines between the landmarks stay within a few pixels, and the residual says about one", () => {
    const camera = cameraAt(eyes[1]!, MIDDLE);
    const random = seeded(2);
    const [worst, residuals]: [number[], number[]] = [[], []];
    for (let trial = 0; trial < 40; trial += 1) {
      const found = solved(projectionThrough(seenBy(camera, LANDMARKS, () => normal(random))));
      residuals.push(found.rmsPixels);
      worst.push(Math.max(...LANDMARKS.map((point) => {
        const [a, b] = [project(found.camera, point).at, project(camera, point).at];
        return Math.hypot(a[0] - b[0], a[1] - b[1]);
      })));
    }
    const mean = (values: number[]): number => values.reduce((sum, value) => sum + value, 0) / values.length;
    expect(mean(worst)).toBeLessThan(3.5);
    // Two coordinates a point, eleven of them taken by the matrix: sqrt(2 (1 - 11 / 24)) = 1.04 pixels.
    expect(mean(residuals)).toBeGreaterThan(0.85);
    expect(mean(residuals)).toBeLessThan(1.25);
  });

  test("the refinement leaves a smaller residual than any small change of the matrix does", () => {
    const camera = cameraAt(eyes[0]!, MIDDLE);
    const random = seeded(3);
    const sightings = seenBy(camera, LANDMARKS, () => 3 * normal(random));
    const { camera: found, rmsPixels } = solved(projectionThrough(sightings));
    const rms = (one: Camera): number => Math.sqrt(sightings.reduce((sum, { point, at }) => {
      const seen = project(one, point).at;
      return sum + (seen[0] - at[0]) ** 2 + (seen[1] - at[1]) ** 2;
    }, 0) / sightings.length);
    expect(rms(found)).toBeCloseTo(rmsPixels, 9);
    found.forEach((value, k) => {
      for (const factor of [1 - 1e-4, 1 + 1e-4]) expect(rms(found.map((each, i) => (i === k ? value * factor : each)))).toBeGreaterThanOrEqual(rmsPixels - 1e-9);
    });
  });

  test("a click that is far off has the largest residual, in pixels and in millimetres on the body", () => {
    const camera = cameraAt(eyes[0]!, MIDDLE);
    const sightings = seenBy(camera, LANDMARKS).map((each, i): Sighting => (i === 4 ? { ...each, at: [each.at[0] + 60, each.at[1]] } : each));
    const { pixels, mm } = solved(projectionThrough(sightings));
    expect(pixels.indexOf(Math.max(...pixels))).toBe(4);
    expect(mm.indexOf(Math.max(...mm))).toBe(4);
    expect(besideSight(camera, sightings[4]!.point, sightings[4]!.at)).toBeCloseTo((60 * 1500) / 2000, -1); // pixels over focal length, at 1.5 m
  });
});

describe("what fixes no projector is refused", () => {
  const camera = cameraAt(from(300, 200, 1400), MIDDLE);

  test("five points are too few", () => {
    expect(projectionThrough(seenBy(camera, LANDMARKS.slice(0, 5)))).toBe("tooFew");
  });

  test.each([[0, 0], [0, 0.5], [0, 2], [5, 0], [5, 2]])("points within %s mm of one plane, clicks %s pixels off", (thick, off) => {
    const random = seeded(4);
    const flat = LANDMARKS.map(([x, y]) => [x, y, MIDDLE[2] + 0.2 * x + thick * (2 * random() - 1)] as Vector);
    expect(projectionThrough(seenBy(camera, flat, () => off * normal(random)))).toBe("flat");
  });

  test("points on one line, and one place clicked for all", () => {
    const line = LANDMARKS.map((_, i) => from(0, 30 * i, 10 * i));
    expect(projectionThrough(seenBy(camera, line))).toBe("flat");
    expect(projectionThrough(LANDMARKS.map((point) => ({ point, at: [500, 500] })))).toBe("flat");
  });

  test("left and right exchanged", () => {
    const exchanged = seenBy(camera, LANDMARKS).map(({ point, at }): Sighting => ({ point, at: [1920 - at[0], at[1]] }));
    expect(projectionThrough(exchanged)).toBe("mixedUp");
  });

  test("six landmarks that are no plane are enough", () => {
    const names = Object.keys(EXAMPLE.landmarks);
    const six = ["suprasternal_notch", "umbilicus", "nipple_L", "nipple_R", "acromion_L", "acromion_R"].map((name) => LANDMARKS[names.indexOf(name)]!);
    const found = solved(projectionThrough(seenBy(camera, six)));
    expect(found.rmsPixels).toBeLessThan(1e-6);
  });
});

test("a parallel view at true scale: millimetres are so many pixels long at any depth, from each side", () => {
  const frame = { up: [0, 1, 0] as Vector, front: [0, 0, 1] as Vector };
  const front = parallelCamera(frame, "front", 3.8, [10, 20, 30], [500, 400]);
  expect(project(front, [10, 20, 30]).at).toEqual([500, 400]);
  expect(project(front, [110, 20, 90]).at[0]).toBeCloseTo(880, 9); // the patient's left is to the right
  expect(project(front, [10, 120, -50]).at[1]).toBeCloseTo(20, 9);
  expect(towardsEye(front, [0, 0, 0])).toEqual([0, 0, 1].map((value) => expect.closeTo(value, 12) as number));
  const left = parallelCamera(frame, "left", 2, [0, 0, 0], [0, 0]);
  expect(project(left, [0, 0, 100]).at[0]).toBeCloseTo(-200, 9); // seen from her left she looks to the left
  expect(towardsEye(left, [0, 0, 0])[0]).toBeCloseTo(1, 12);
  expect(eyeOf(front)).toBeNull();
  expect(handedness(front)).toBe(0);
});

test("eigenvectors of a symmetric matrix are orthonormal and put it together again", () => {
  const random = seeded(5);
  const root = Array.from({ length: 12 }, () => Array.from({ length: 12 }, () => normal(random)));
  const matrix = root.map((a) => root.map((b) => a.reduce((sum, value, k) => sum + value * b[k]!, 0)));
  const { values, vectors } = symmetricEigen(matrix);
  matrix.forEach((row, i) => row.forEach((value, k) => expect(vectors.reduce((sum, vector, n) => sum + values[n]! * vector[i]! * vector[k]!, 0)).toBeCloseTo(value, 8)));
  vectors.forEach((a, i) => vectors.forEach((b, k) => expect(a.reduce((sum, value, n) => sum + value * b[n]!, 0)).toBeCloseTo(i === k ? 1 : 0, 10)));
  expect([...values].sort((a, b) => a - b)).toEqual(values);
});
