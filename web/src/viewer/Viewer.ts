// The one WebGL view: renderer, camera, controls and a loop that draws only when something changed.
// `body` is the scan's own frame (metres); it is turned so that the patient stands upright and faces +Z, hence the
// camera always has +Y up and "from the front" means the same for every scan.
import { type Box3, Group, Matrix4, MOUSE, PerspectiveCamera, Scene, Spherical, TOUCH, Vector2, Vector3, WebGLRenderer } from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import type { Frame, Vector } from "../api/types";
import { metresFromMm, mmFromMetres } from "../ui/units";
import { CameraMove } from "./CameraMove";
import { leftOf } from "./frame";
import { quality, ratioAtRest, restTimer } from "./graphics";
import { addLights } from "./lights";
import { type Palette, readPalette } from "./palette";
import type { ViewName } from "./state";

/** Where the view stands on the page. */
export interface Stage {
  readonly host: HTMLElement;
  readonly canvas: HTMLCanvasElement;
  /** over the canvas: for marks and letters, which are DOM and always sharp */
  readonly overlay: HTMLElement;
}

/** One visible thing, brought up to date with the parts of the state that it shows. */
export interface Part<State> {
  update(state: State): void;
}

/** A part that fails must not keep the others from drawing, nor the state from changing: its error is reported later. */
export function updateEach<State>(parts: readonly Part<State>[], state: State): void {
  for (const part of parts) {
    try {
      part.update(state);
    } catch (error) {
      queueMicrotask(() => reportError(error));
    }
  }
}

/** Says when the browser takes the graphics away, which is asked to bring them back. */
export function followGraphics(canvas: HTMLCanvasElement, viewer: Viewer, say: (now: "ok" | "lost") => void): void {
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  canvas.addEventListener("webglcontextlost", (event) => {
    event.preventDefault();
    say("lost");
  });
  canvas.addEventListener("webglcontextrestored", () => {
    say("ok");
    viewer.invalidate();
  });
}

const FIELD_OF_VIEW = 26; // degrees; long enough a lens that a torso is not distorted
const MARGIN = 1.24; // above and below
const CLOSE = 0.15; // metres above and below a place that is looked at closely: more than a rough guess is off
const AVERSION = 0.35; // cosine; skin that looks farther away from the eye is looked at from its own side
const BESIDE = 0.09; // metres on each side: for the ruler and the letters

/** Unit vectors from the body to the eye. */
const DIRECTIONS: Record<ViewName, Vector3> = {
  front: new Vector3(0, 0, 1),
  left: new Vector3(1, 0, 0),
  right: new Vector3(-1, 0, 0),
  back: new Vector3(0, 0, -1),
  top: new Vector3(0, 1, 0.001).normalize(), // a hair to the front: straight down has no upright
};

export class Viewer {
  readonly scene = new Scene();
  readonly body = new Group();
  readonly camera = new PerspectiveCamera(FIELD_OF_VIEW, 1, 0.05, 20);
  readonly renderer: WebGLRenderer;
  readonly overlay: HTMLElement;
  /** Called before each picture, when the camera is known: DOM parts place themselves here. */
  readonly beforeFrame = new Set<() => void>();
  /** Half sizes of the body in the view's axes, metres. */
  readonly half = new Vector3(0.25, 0.35, 0.15);
  /** Called when the camera has another pose. */
  readonly turned = new Set<() => void>();
  /** The next body is seen from where this one is, not from the front. */
  keepsPose = false;
  /** Something inside is looked at: scan and model let it through. */
  isGlass = false;
  /** A hand is on this view. */
  isHeld = false;
  palette: Palette = readPalette();
  frames = 0;
  private view: ViewName = "front";

  private readonly controls: OrbitControls;
  private readonly move: CameraMove;
  private far: { readonly away: number; readonly target: Vector3 } | null = null; // while the eye is near: from where it came
  private isAsked = false;
  private readonly ratio: number; // pixels on a side for one of the page's, in pictures that move
  private readonly moved = restTimer(() => {
    if (this.isAsked) return;
    this.renderer.setPixelRatio(this.ratioAtRest);
    this.draw();
  });

  /** Throws when the browser has no WebGL 2. */
  constructor(
    readonly host: HTMLElement,
    canvas: HTMLCanvasElement,
    overlay: HTMLElement,
    prefersStill: () => boolean,
  ) {
    const { samples, pixelRatio } = quality();
    this.renderer = new WebGLRenderer({ canvas, antialias: samples > 1, powerPreference: "high-performance" });
    this.ratio = Math.min(window.devicePixelRatio, pixelRatio);
    this.renderer.setPixelRatio(this.ratio);
    this.overlay = overlay;
    this.body.name = "body";
    this.scene.add(this.body);
    addLights(this.scene, this.camera);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.rotateSpeed = 0.9;
    this.controls.zoomToCursor = true;
    this.controls.minDistance = 0.15;
    this.controls.maxDistance = 8;
    this.controls.addEventListener("change", () => {
      this.invalidate();
      for (const listener of this.turned) listener();
    });
    this.controls.addEventListener("start", () => (this.isHeld = true));
    this.controls.addEventListener("end", () => (this.isHeld = false));
    this.move = new CameraMove(this.camera, this.controls, () => this.invalidate(), prefersStill);
    this.repaint();
    this.resize();
    this.lookFrom("front", false);
    new ResizeObserver(() => this.resize()).observe(host);
  }

  /** Whether dragging turns the body. */
  set mayTurn(may: boolean) {
    this.controls.enabled = may;
  }

  /** While the first button or one finger draws, the second button and two fingers turn the body; where a pen draws, fingers do as always. */
  drawWith(what: "nothing" | "anything" | "pen"): void {
    const isOn = what !== "nothing";
    const byFinger = what === "anything";
    this.controls.mouseButtons = { LEFT: isOn ? null : MOUSE.ROTATE, MIDDLE: MOUSE.DOLLY, RIGHT: isOn ? MOUSE.ROTATE : MOUSE.PAN };
    this.controls.touches = { ONE: byFinger ? null : TOUCH.ROTATE, TWO: byFinger ? TOUCH.DOLLY_ROTATE : TOUCH.DOLLY_PAN };
  }

  /** No picture is asked for that is not drawn yet: nothing moves. */
  get isAtRest(): boolean {
    return !this.isAsked;
  }

  /** Asks for a new picture; many requests before the next frame are one. */
  invalidate(): void {
    if (this.isAsked) return;
    this.isAsked = true;
    requestAnimationFrame((now) => {
      this.isAsked = false;
      this.move.advance(now);
      this.drawMoving();
    });
  }

  /** As fine as the page can follow; finer once nothing moves any more. */
  private drawMoving(): void {
    if (this.renderer.getPixelRatio() !== this.ratio) this.renderer.setPixelRatio(this.ratio);
    this.draw();
    if (this.ratioAtRest !== this.ratio) this.moved();
  }

  private get ratioAtRest(): number {
    return ratioAtRest(quality(), this.ratio, this.host.clientWidth, this.host.clientHeight);
  }

  /** Depth-buffer units that one metre is worth where the body stands; polygon offsets are counted in them. */
  get depthUnits(): number {
    const { near, far } = this.camera;
    const distance = this.camera.position.distanceTo(this.controls.target);
    return (2 ** 24 * near * far) / ((far - near) * distance ** 2);
  }

  /** Where the eye is and what it looks at, in the view's axes. */
  get pose(): { eye: Vector3; target: Vector3 } {
    return { eye: this.camera.position.clone(), target: this.controls.target.clone() };
  }

  set pose({ eye, target }) {
    this.camera.position.copy(eye);
    this.controls.target.copy(target);
    this.controls.update();
    this.invalidate();
  }

  /** Where the eye is, in the scan's axes, mm. */
  get eye(): Vector {
    return this.body.worldToLocal(this.camera.position.clone()).toArray().map(mmFromMetres) as Vector;
  }

  /** Unit vector from the body to the eye, in the view's axes. */
  get gaze(): Vector3 {
    return this.camera.position.clone().sub(this.controls.target).normalize();
  }

  draw(): void {
    this.scene.updateMatrixWorld();
    for (const part of this.beforeFrame) part();
    this.renderer.render(this.scene, this.camera);
    this.frames += 1;
  }

  /** Draws once with so many pixels for each of the page's, hands the canvas over, and goes back. */
  drawAt(times: number, use: (canvas: HTMLCanvasElement) => void): void {
    const own = this.renderer.getPixelRatio();
    this.renderer.setPixelRatio(times);
    this.draw();
    use(this.renderer.domElement);
    this.renderer.setPixelRatio(own);
    this.draw();
  }

  /** Pixels of the page that one metre is long at the middle of what is looked at. */
  get pixelsPerMetre(): number {
    const away = this.camera.position.distanceTo(this.controls.target);
    return this.host.clientHeight / (2 * Math.tan((FIELD_OF_VIEW * Math.PI) / 360) * away);
  }

  /** Page pixels as the camera's coordinates (-1 to 1). */
  toCamera(clientX: number, clientY: number): Vector2 {
    const box = this.host.getBoundingClientRect();
    return new Vector2(((clientX - box.left) / box.width) * 2 - 1, 1 - ((clientY - box.top) / box.height) * 2);
  }

  private fitDistance(name: ViewName): number {
    const tangent = Math.tan((FIELD_OF_VIEW * Math.PI) / 360);
    const { x, y, z } = this.half;
    const [across, up, deep] = name === "top" ? [x, z, y] : name === "left" || name === "right" ? [z, y, x] : [x, y, z];
    return Math.max(MARGIN * up, (across + BESIDE) / this.camera.aspect) / tangent + deep;
  }

  repaint(): void {
    this.palette = readPalette();
    this.renderer.setClearColor(this.palette.canvas, 1);
    this.invalidate();
  }

  /** Stands the body upright by `frame` and puts `box` (scan's axes, metres, as corners) in the middle. */
  stand(frame: Frame, boxInView: Box3): void {
    this.body.matrix.copy(viewFromScan(frame));
    this.body.matrix.decompose(this.body.position, this.body.quaternion, this.body.scale);
    boxInView.getCenter(this.body.position).negate();
    boxInView.getSize(this.half).multiplyScalar(0.5);
    this.body.updateMatrixWorld(true);
    this.invalidate();
  }

  lookFrom(name: ViewName, isMoving = true): void {
    this.far = null;
    this.view = name;
    this.move.to(DIRECTIONS[name].clone().multiplyScalar(this.fitDistance(name)), new Vector3(), isMoving);
  }

  /**
   * Comes near to a place (scan's axes, mm), from the side that the eye is on or, where the skin looks away from it, from
   * where `normal` points; null goes back to the distance before.
   */
  closeUp(place: Vector | null, normal: Vector3 | null = null): void {
    const { eye, target } = this.pose;
    if (place === null) {
      const { far } = this;
      this.far = null;
      if (far) this.move.to(this.gaze.multiplyScalar(far.away), far.target, true);
      return;
    }
    this.far ??= { away: eye.distanceTo(target), target };
    this.scene.updateMatrixWorld();
    const at = this.body.localToWorld(new Vector3(...place.map(metresFromMm)));
    const outwards = normal?.clone().transformDirection(this.body.matrixWorld) ?? null;
    const isSeen = outwards === null || outwards.dot(this.gaze) > AVERSION;
    const from = this.gaze;
    if (!isSeen) {
      const half = from.add(outwards); // half way round, so that one still knows where one is
      if (half.length() < 0.3) half.copy(outwards); // it lies on the far side
      half.setY(Math.min(0.5, Math.max(-0.5, half.y))).normalize(); // from aside rather than from above
    }
    this.move.to(from.multiplyScalar(Math.min(this.far.away, CLOSE / Math.tan((FIELD_OF_VIEW * Math.PI) / 360))), at, true);
  }

  /** Comes so near to a place (scan's axes, mm) that `half` metres are seen above and below it; `from`: unit vector to the eye, in the view's axes. */
  faceTo(place: Vector, from: Vector3, half: number): void {
    const at = this.body.localToWorld(new Vector3(...place.map(metresFromMm)));
    this.move.to(from.clone().multiplyScalar(half / Math.tan((FIELD_OF_VIEW * Math.PI) / 360)), at, true);
  }

  /** Back to where the eye was. */
  travel({ eye, target }: Viewer["pose"]): void {
    this.move.to(eye.clone().sub(target), target, true);
  }

  /** The eye is at once where it is going to. */
  settle(): void {
    this.move.finish();
    this.scene.updateMatrixWorld();
  }

  /** Turns the body before the eye, as a drag by the mouse does; degrees to the right and downwards. */
  turnBy(right: number, down: number): void {
    const seen = new Spherical().setFromVector3(this.camera.position.clone().sub(this.controls.target));
    seen.theta -= (right * Math.PI) / 180;
    seen.phi = Math.min(Math.max(seen.phi - (down * Math.PI) / 180, 0.01), Math.PI - 0.01); // straight down has no upright
    this.camera.position.setFromSpherical(seen).add(this.controls.target);
    this.controls.update();
  }

  /** The distance to the body, times a factor. */
  zoomBy(factor: number): void {
    const away = this.camera.position.clone().sub(this.controls.target).multiplyScalar(factor);
    away.clampLength(this.controls.minDistance, this.controls.maxDistance);
    this.camera.position.copy(away).add(this.controls.target);
    this.controls.update();
  }

  /** Pixels in the host's box of a point in the scan's axes (metres), and its distance from the eye. */
  toScreen(point: Vector3): { x: number; y: number; depth: number } {
    const seen = this.body.localToWorld(point.clone());
    const depth = seen.distanceTo(this.camera.position);
    seen.project(this.camera);
    const { clientWidth, clientHeight } = this.host;
    return { x: ((seen.x + 1) / 2) * clientWidth, y: ((1 - seen.y) / 2) * clientHeight, depth };
  }

  /** Page pixels of a point in the scan's axes, millimetres. */
  toPage(point: Vector): { x: number; y: number } {
    const box = this.host.getBoundingClientRect();
    this.scene.updateMatrixWorld();
    const { x, y } = this.toScreen(new Vector3(...point.map(metresFromMm)));
    return { x: x + box.left, y: y + box.top };
  }

  private resize(): void {
    const { clientWidth, clientHeight } = this.host;
    if (clientWidth === 0 || clientHeight === 0) return;
    const before = this.fitDistance(this.view);
    this.camera.aspect = clientWidth / clientHeight;
    this.camera.updateProjectionMatrix();
    // Another width for the same body: closer or farther away, from where the person looks.
    const factor = this.fitDistance(this.view) / before;
    if (Math.abs(factor - 1) > 0.001) this.zoomBy(factor);
    this.renderer.setSize(clientWidth, clientHeight, false);
    this.drawMoving(); // at once: a resized canvas is empty until it is drawn
  }
}

/** Rotation that takes the scan's axes to the view's: patient's left to +X, head to +Y, front to +Z. */
export function viewFromScan(frame: Frame): Matrix4 {
  const basis = new Matrix4().makeBasis(new Vector3(...leftOf(frame)), new Vector3(...frame.up), new Vector3(...frame.front));
  return basis.transpose();
}
