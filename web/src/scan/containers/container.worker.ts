// Decodes one file beside the page.  The service's policy lets this worker compile WebAssembly, and nothing else of the page.
import dracoWasm from "three/examples/jsm/libs/draco/gltf/draco_decoder.wasm?url";
import { assetBytes } from "../../api/asset";
import { decodeGlb, type Tools } from "./decodeGlb";
import type { ContainerKind } from "./kind";
import { BadContainer } from "./limits";
import * as text from "./text";

export interface ContainerQuestion {
  readonly kind: ContainerKind;
  readonly bytes: ArrayBuffer;
}
export type ContainerAnswer = { readonly glb: ArrayBuffer } | { readonly problem: string };

const JPEG_QUALITY = 0.95;

let dracoOpened: ReturnType<Tools["draco"]> | null = null;

async function openedDraco(): ReturnType<Tools["draco"]> {
  const [{ openDraco }, wasm] = await Promise.all([import("./draco"), assetBytes(dracoWasm)]);
  return openDraco(wasm);
}

const tools: Tools = {
  draco: () => (dracoOpened ??= openedDraco()),
  plainPicture: async (bytes, kind) => {
    try {
      const picture = await createImageBitmap(new Blob([bytes.slice()], { type: kind }), { colorSpaceConversion: "none", imageOrientation: "none" });
      const canvas = new OffscreenCanvas(picture.width, picture.height);
      canvas.getContext("2d")!.drawImage(picture, 0, 0);
      const blob = await canvas.convertToBlob({ type: "image/jpeg", quality: JPEG_QUALITY });
      return { bytes: new Uint8Array(await blob.arrayBuffer()), kind: "image/jpeg" };
    } catch {
      return null;
    }
  },
};

addEventListener("message", ({ data }: MessageEvent<ContainerQuestion>) => void answer(data));

async function answer({ kind, bytes }: ContainerQuestion): Promise<void> {
  try {
    const { buffer } = kind === "glb" ? await decodeGlb(new Uint8Array(bytes), tools) : await (await import("./decodeUsd")).decodeUsd(new Uint8Array(bytes));
    postMessage({ glb: buffer } satisfies ContainerAnswer, { transfer: [buffer] });
  } catch (error) {
    postMessage({ problem: error instanceof BadContainer ? error.message : text.damaged } satisfies ContainerAnswer);
  }
}
