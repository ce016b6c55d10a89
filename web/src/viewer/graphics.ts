// Whether pictures are drawn by a graphics card or by the processor, which many computers in hospitals leave it to.  There the
// page draws fewer pixels, each once: with four samples a pixel a turning body stutters.

/** What drivers that draw on the processor call themselves: SwiftShader, Mesa, Windows, macOS. */
const SOFTWARE = /swiftshader|llvmpipe|softpipe|swrast|software|basic render/i;

export const isSoftware = (renderer: string): boolean => SOFTWARE.test(renderer);

export interface Quality {
  readonly samples: 0 | 4; // for each pixel; 0: edges are not smoothed
  readonly pixelRatio: number; // the most pixels on a side for one of the page's
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
  const told = String(gl.getParameter(gl.RENDERER));
  const more = told === "WebKit WebGL" ? gl.getExtension("WEBGL_debug_renderer_info") : null; // Firefox tells without it
  const found = more ? String(gl.getParameter(more.UNMASKED_RENDERER_WEBGL)) : told;
  gl.getExtension("WEBGL_lose_context")?.loseContext(); // a page may hold few of them
  return found;
}
