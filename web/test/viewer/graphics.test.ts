import { expect, test } from "vitest";
import { isSoftware } from "../../src/viewer/graphics";

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
