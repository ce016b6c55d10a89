// Whether pictures are drawn by a graphics card or by the processor, which many computers in hospitals leave it to.  There the
// page draws fewer pixels, each once: with four samples a pixel a turning body stutters.  What rests is drawn once more, finer.

/** What drivers that draw on the processor call themselves: SwiftShader, Mesa, Windows, macOS. */
const SOFTWARE = /swiftshader|llvmpipe|softpipe|swrast|software|basic render/i;

export const isSoftware = (renderer: string): boolean => SOFTWARE.test(renderer);

export interface Quality {
  readonly samples: 0 | 4; // for each pixel; 0: edges are not smoothed
  readonly pixelRatio: number; // the most pixels on a side for one of the page's
}

const AT_REST_MS = 250; // after the last picture that something moved in
const AT_REST_RATIO = 2;
const AT_REST_PIXELS = 4_000_000; // a quarter of a second's work
const WORTH_IT = 1.25; // finer than the page's own pixels

/** Pixels on a side for one of the page's in a picture that rests; that of moving ones where finer is not worth it. */
export function ratioAtRest({ samples }: Pick<Quality, "samples">, moving: number, width: number, height: number): number {
  if (samples > 0 || moving < 1) return moving;
  const ratio = Math.min(AT_REST_RATIO, Math.sqrt(AT_REST_PIXELS / (width * height)));
  return ratio < WORTH_IT * moving ? moving : ratio;
}

/** Calls `rested` once nothing has moved for a moment. */
export function restTimer(rested: () => void): () => void {
  let timer: ReturnType<typeof setTimeout> | undefined;
  return () => {
    clearTimeout(timer);
    timer = setTimeout(rested, AT_REST_MS);
  };
}

let known: Quality | null = null;

/** Asked of the browser once; it costs a drawing surface of one pixel. */
export function quality(): Quality {
  known ??= isSoftware(rendererName()) ? { samples: 0, pixelRatio: 1 } : { samples: 4, pixelRatio: 2 };
  return known;
}

/** Empty where there is none, or the browser does not tell. */
function rendererName(): string {
  const gl = document.createElement("canvas").getContext("webgl2");
  if (!gl) return "";
  const renderer = String(gl.getParameter(gl.RENDERER));
  const more = renderer === "WebKit WebGL" ? gl.getExtension("WEBGL_debug_renderer_info") : null; // Firefox tells without it
  const found = more ? String(gl.getParameter(more.UNMASKED_RENDERER_WEBGL)) : renderer;
  gl.getExtension("WEBGL_lose_context")?.loseContext(); // a page may hold few of them
  return found;
}
