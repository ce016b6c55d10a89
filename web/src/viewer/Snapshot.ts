// Draws a scene into an ordinary 2D canvas through a render target: for the loupe and the little picture of the
// model, which need pixels of their own without another WebGL context.
import { type Camera, Color, type Object3D, type Scene, SRGBColorSpace, type WebGLRenderer, WebGLRenderTarget } from "three";
import { quality } from "./graphics";

export class Snapshot {
  private readonly target: WebGLRenderTarget;
  private readonly pixels: Uint8Array;
  private readonly image: ImageData;

  constructor(
    private readonly renderer: WebGLRenderer,
    readonly size: number,
  ) {
    this.target = new WebGLRenderTarget(size, size, { samples: quality().samples, colorSpace: SRGBColorSpace });
    this.pixels = new Uint8Array(4 * size * size);
    this.image = new ImageData(size, size);
  }

  draw(scene: Scene | Object3D, camera: Camera, background: Color, canvas: HTMLCanvasElement): void {
    const { renderer, size } = this;
    const own = renderer.getClearColor(new Color());
    renderer.setRenderTarget(this.target);
    renderer.setClearColor(background, 1);
    renderer.clear();
    renderer.render(scene, camera);
    renderer.readRenderTargetPixels(this.target, 0, 0, size, size, this.pixels);
    renderer.setRenderTarget(null);
    renderer.setClearColor(own, 1);
    const row = 4 * size;
    for (let y = 0; y < size; y += 1) {
      this.image.data.set(this.pixels.subarray(y * row, (y + 1) * row), (size - 1 - y) * row); // WebGL counts from below
    }
    if (canvas.width !== size) canvas.width = canvas.height = size;
    canvas.getContext("2d")?.putImageData(this.image, 0, 0);
  }
}
