import { expect, test } from "vitest";
import { frameOfRig } from "../../src/fit/upright";
import { standing, straightened, straightenedByFit } from "../../src/landmarks/straighten";
import type { Session } from "../../src/app/session";
import type { ResultBone } from "../../src/api/types.gen";
import type { Picks } from "../../src/landmarks/picks";

const bone = (name: string, [x, y, z]: readonly [number, number, number], degrees: number): ResultBone => {
  const half = (degrees * Math.PI) / 360;
  const sine = Math.sin(half);
  return { name, rotation_xyzw: [x * sine, y * sine, z * sine, Math.cos(half)], translation_m: [0, 0, 0], scale: [1, 1, 1] };
};
const result = (...bones: ReturnType<typeof bone>[]) => ({ parameters: { bones, blendshapes: {} } });

test("the spine's bones say how the body stands; raised arms do not", () => {
  const frame = frameOfRig(result(bone("pelvis", [1, 0, 0], 10), bone("upper_thorax", [1, 0, 0], -10), bone("upper_arm_L", [0, 0, 1], 120)))!;
  expect(frame.up[1]).toBeCloseTo(1, 12);
  expect(frame.front[2]).toBeCloseTo(1, 12);
});

test("a quarter turn about the long axis and one onto the back are told from the bones", () => {
  expect(frameOfRig(result(bone("pelvis", [0, 1, 0], 90)))!.front[0]).toBeCloseTo(1, 12);
  const lying = frameOfRig(result(bone("pelvis", [1, 0, 0], -90)))!;
  expect(lying.up[2]).toBeCloseTo(-1, 12);
  expect(lying.front[1]).toBeCloseTo(1, 12);
});

test("a result without bones says nothing", () => {
  expect(frameOfRig({})).toBeNull();
});

const proposed = (confidence: number) => ({ up: [0, 1, 0] as const, front: [0, 0, 1] as const, confidence, reason: "" }) as never as Parameters<typeof standing>[0];
const pins = (tilt: number): Picks => {
  const turn = ([x, y, z]: readonly [number, number, number]): [number, number, number] => [x, y * Math.cos(tilt) - z * Math.sin(tilt), y * Math.sin(tilt) + z * Math.cos(tilt)];
  return { umbilicus: turn([0, 158, 137.3]), suprasternal_notch: turn([0, 489.9, 72.1]), nipple_L: turn([95, 300, 180]), nipple_R: turn([-95, 300, 180]) };
};

test("landmarks stand the body up where the proposal is a guess or wrong, not where it is a few degrees off", () => {
  expect(standing(proposed(0.8), pins(0.2)).frameFrom).toBe("service");
  expect(standing(proposed(0.35), pins(0.2)).frameFrom).toBe("landmarks");
  expect(standing(proposed(0.8), pins(1.2)).frameFrom).toBe("landmarks");
  expect(standing(proposed(0.35), {}).frameFrom).toBe("service");
});

test("where the proposal took the scanner's own upright, it is upright, not what the chest faces", () => {
  const tilted = { up: [0.044, 0.957, -0.285], front: [-0.146, 0.289, 0.946], confidence: 0.8, reason: "" } as never as Parameters<typeof standing>[0]; // of the example patient
  const { frame } = standing(tilted, {});
  expect(frame.up).toEqual([0, 1, 0]);
  expect(frame.front[1]).toBeCloseTo(0, 12);
  const lying = { up: [-0.64, 0.03, -0.77], front: [0.03, 1, 0.02], confidence: 0.8, reason: "" } as never as Parameters<typeof standing>[0];
  expect(standing(lying, {}).frame.front[1], "a patient who lies stays as she is").toBeGreaterThan(0.99);
});

test("the fit's word counts more than the landmarks', the person's more than both", () => {
  const scan = (frameFrom: string) => ({ scan: { info: { frame: proposed(0.35) }, frame: { up: [0, 1, 0], front: [0, 0, 1] }, frameFrom }, view: { name: "front", asked: 0 } }) as unknown as Pick<Session, "scan" | "view">;
  const turned = frameOfRig(result(bone("pelvis", [1, 0, 0], 12)))!;
  expect(straightenedByFit(scan("landmarks"), turned)).toMatchObject({ scan: { frameFrom: "fit", frame: turned }, view: { asked: 1 } });
  expect(straightenedByFit(scan("person"), turned)).toEqual({});
  expect(straightened(scan("fit"), pins(0.5))).toEqual({});
  expect(straightened(scan("service"), pins(0.5))).toMatchObject({ scan: { frameFrom: "landmarks" } });
});
