import { afterEach, expect, test, vi } from "vitest";
import { isSoftware, ratioAtRest, restTimer } from "../../src/viewer/graphics";

test.each([
  ["ANGLE (Google, Vulkan 1.3.0 (SwiftShader Device (Subzero) (0x0000C0DE)), SwiftShader driver)", true],
  ["ANGLE (Mesa, llvmpipe (LLVM 15.0.7, 256 bits), OpenGL 4.5)", true],
  ["llvmpipe", true],
  ["ANGLE (Microsoft, Microsoft Basic Render Driver Direct3D11 vs_5_0 ps_5_0, D3D11)", true],
  ["Apple Software Renderer", true],
  ["ANGLE (Intel, Intel(R) UHD Graphics 620 (0x00005917) Direct3D11 vs_5_0 ps_5_0, D3D11)", false],
  ["ANGLE (NVIDIA, NVIDIA GeForce RTX 3060 (0x00002544) Direct3D11 vs_5_0 ps_5_0, D3D11)", false],
  ["ANGLE (Apple, ANGLE Metal Renderer: Apple M1, Unspecified Version)", false],
  ["Mesa Intel(R) UHD Graphics (TGL GT1)", false],
  ["WebKit WebGL", false],
  ["", false],
])("%s: on the processor %s", (renderer, expected) => {
  expect(isSoftware(renderer)).toBe(expected);
});

afterEach(() => void vi.useRealTimers());

test("without a graphics card a picture that rests is drawn finer, as far as that is no long work", () => {
  const soft = { samples: 0 } as const;
  expect(ratioAtRest(soft, 1, 1000, 700)).toBe(2);
  expect(ratioAtRest(soft, 1, 1600, 1000)).toBeCloseTo(Math.sqrt(2.5), 6);
  expect(ratioAtRest(soft, 1, 2560, 1440), "hardly finer than the page's own pixels").toBe(1);
  expect(ratioAtRest(soft, 0.5, 1000, 700), "a page that is shown small").toBe(0.5);
  expect(ratioAtRest({ samples: 4 }, 2, 1000, 700), "smooth as it is").toBe(2);
});

test("a picture rests a moment after the last movement, once", () => {
  vi.useFakeTimers();
  const rested = vi.fn();
  const moved = restTimer(rested);
  moved();
  vi.advanceTimersByTime(200);
  moved();
  vi.advanceTimersByTime(200);
  expect(rested).not.toHaveBeenCalled();
  vi.advanceTimersByTime(1000);
  expect(rested).toHaveBeenCalledOnce();
});
