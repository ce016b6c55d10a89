// The one WebGL view: renderer, camera, controls and a loop that draws only when something changed.
// `body` is the scan's own frame (metres); it is turned so that the patient stands upright and faces +Z, hence the
// camera always has +Y up and "from the front" means the same for every scan.
import { Box3, Group, Matrix4, PerspectiveCamera, Scene, Vector3, WebGLRenderer } from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import type { Frame } from "../api/types";
import { leftOf } from "../state/frame";
import type { Session, ViewName } from "../state/session";
import { CameraMove } from "./CameraMove";
import { addLights } from "./lights";
import { type Palette, readPalette } from "./palette";

/** One visible thing. */
export interface Part {
  update(state: Session): void;
}

const FIELD_OF_VIEW = 26; // degrees; long enough a lens that a torso is not distorted
const MARGIN = 1.24;

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
  palette: Palette = readPalette();
  frames = 0;

  private readonly controls: OrbitControls;
  private readonly move: CameraMove;
  private isAsked = false;

  /** Throws when the browser has no WebGL 2. */
  constructor(
    readonly host: HTMLElement,
    canvas: HTMLCanvasElement,
    overlay: HTMLElement,
    prefersStill: () => boolean,
  ) {
    this.renderer = new WebGLRenderer({ canvas, antialias: true, powerPreference: "high-performance" });
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.overlay = overlay;
    this.body.name = "body";
    this.scene.add(this.body);
    addLights(this.scene, this.camera);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.rotateSpeed = 0.9;
    this.controls.zoomToCursor = true;
    this.controls.minDistance = 0.15;
    this.controls.maxDistance = 8;
    this.controls.addEventListener("change", () => this.invalidate());
    this.move = new CameraMove(this.camera, this.controls, () => this.invalidate(), prefersStill);
    this.repaint();
    this.resize();
    this.lookFrom("front", false);
    new ResizeObserver(() => this.resize()).observe(host);
  }

  /** Asks for a new picture; many requests before the next frame are one. */
  invalidate(): void {
    if (this.isAsked) return;
    this.isAsked = true;
    requestAnimationFrame((now) => {
      this.isAsked = false;
      this.move.advance(now);
      this.draw();
    });
  }

  /** Depth-buffer units that one metre is worth where the body stands; polygon offsets are counted in them. */
  get depthUnits(): number {
    const { near, far } = this.camera;
    const distance = this.camera.position.distanceTo(this.controls.target);
    return (2 ** 24 * near * far) / ((far - near) * distance ** 2);
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
    const direction = DIRECTIONS[name];
    const tangent = Math.tan((FIELD_OF_VIEW * Math.PI) / 360);
    const { x, y, z } = this.half;
    const [across, up, deep] = name === "top" ? [x, z, y] : name === "left" || name === "right" ? [z, y, x] : [x, y, z];
    const distance = (MARGIN * Math.max(up, across / this.camera.aspect)) / tangent + deep;
    this.move.to(direction.clone().multiplyScalar(distance), new Vector3(), isMoving);
  }

  /** Pixels in the host's box of a point in the scan's axes (metres), and its distance from the eye. */
  toScreen(point: Vector3): { x: number; y: number; depth: number } {
    const seen = this.body.localToWorld(point.clone());
    const depth = seen.distanceTo(this.camera.position);
    seen.project(this.camera);
    const { clientWidth, clientHeight } = this.host;
    return { x: ((seen.x + 1) / 2) * clientWidth, y: ((1 - seen.y) / 2) * clientHeight, depth };
  }

  private resize(): void {
    const { clientWidth, clientHeight } = this.host;
    if (clientWidth === 0 || clientHeight === 0) return;
    this.camera.aspect = clientWidth / clientHeight;
    this.camera.updateProjectionMatrix();
    this.renderer.setSize(clientWidth, clientHeight, false);
    this.draw(); // at once: a resized canvas is empty until it is drawn
  }
}

/** Rotation that takes the scan's axes to the view's: patient's left to +X, head to +Y, front to +Z. */
export function viewFromScan(frame: Frame): Matrix4 {
  const basis = new Matrix4().makeBasis(new Vector3(...leftOf(frame)), new Vector3(...frame.up), new Vector3(...frame.front));
  return basis.transpose();
}
