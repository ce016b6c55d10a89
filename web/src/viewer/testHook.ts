// For browser tests, and for nobody else: a read-only look at what the page knows and where things are drawn.
//   window.__breastrig.state()          the session, without its binary parts
//   window.__breastrig.isReady()        the scan is drawn, can be picked on and stands where it will stand
//   window.__breastrig.isAtRest()       no picture is asked for that is not drawn yet, in no pane
//   window.__breastrig.project([x,y,z]) page pixels of a point (scan's frame, mm) and whether the scan hides it
//   window.__breastrig.pickAt(x, y)     point (scan's frame, mm) and triangle under page pixels, or null
//   window.__breastrig.surfaceAt(x, y)  corners and weights of the fitted surface's triangle there, while it is shown
//   window.__breastrig.other()          the same of the other stance's pane, and its camera
//   window.__breastrig.pose()           the camera of the stance in work
//   window.__breastrig.halo(isOther)    how wide the bands of lines are drawn, mm: least and most; null without any
//   window.__breastrig.memory()         how many geometries, textures and programs it holds on the graphics card
//   window.__breastrig.picture()        what is really on the canvas: number of colours, a checksum, context lost or not
import { Vector3 } from "three";
import type { Vector } from "../api/types";
import { metresFromMm, mmFromMetres } from "../ui/units";
import { type Hit, isHidden, pickAt, type Surface, surfaceAt, type SurfaceHit } from "./picking";
import type { Viewer } from "./Viewer";

interface Picture {
  colours: number;
  checksum: number;
  isLost: boolean;
}

/** A second pane, once its body is drawn. */
export interface OtherPane {
  isReady(): boolean;
  viewer(): Viewer | null;
}

export interface TestHook<State> {
  state(): State;
  isReady(): boolean;
  frames(): number;
  isAtRest(): boolean;
  project(point: Vector): { x: number; y: number; hidden: boolean };
  pickAt(x: number, y: number): Hit | null;
  surfaceAt(x: number, y: number): SurfaceHit | null;
  halo(isOther?: boolean): readonly [least: number, most: number] | null;
  memory(): Record<"geometries" | "textures" | "programs", number>;
  picture(): Picture;
  /** the pane of the other stance, once its scan is drawn */
  other(): { picture: Picture; pose: Record<"eye" | "target", Vector> } | null;
  /** of the camera, in the view's axes, metres */
  pose(): Record<"eye" | "target", Vector>;
}

export function offerTestHook(state: () => unknown, viewer: Viewer, scan: Surface & { readonly isSettled: boolean }, fitted: Pick<Surface, "mesh">, other?: OtherPane): void {
  const hook: TestHook<unknown> = {
    state,
    isReady: () => scan.isSettled,
    frames: () => viewer.frames,
    isAtRest: () => viewer.isAtRest && other?.viewer()?.isAtRest !== false,
    project(point) {
      const at = new Vector3(...point.map(metresFromMm));
      const box = viewer.host.getBoundingClientRect();
      viewer.scene.updateMatrixWorld();
      const { x, y } = viewer.toScreen(at);
      return { x: x + box.left, y: y + box.top, hidden: isHidden(viewer, scan, at, scan.normalAt(at)) };
    },
    pickAt: (x, y) => pickAt(viewer, scan, x, y),
    surfaceAt: (x, y) => surfaceAt(viewer, fitted.mesh, x, y),
    halo: (isOther = false) => haloOf(isOther ? (other?.viewer() ?? null) : viewer),
    memory: () => ({ ...viewer.renderer.info.memory, programs: viewer.renderer.info.programs?.length ?? 0 }),
    picture: () => readPicture(viewer),
    other: () => {
      const pane = other?.isReady() ? other.viewer() : null;
      return pane && { picture: readPicture(pane), pose: poseOf(pane) };
    },
    pose: () => poseOf(viewer),
  };
  Object.defineProperty(window, "__breastrig", { value: Object.freeze(hook) });
}

const poseOf = ({ pose }: Viewer): Record<"eye" | "target", Vector> => ({ eye: pose.eye.toArray(), target: pose.target.toArray() });

/** Of what is on the stage, by the radii that its one mesh is made of. */
function haloOf(viewer: Viewer | null): readonly [number, number] | null {
  const radii = (viewer?.body.getObjectByName("halo of lines")?.userData.radii ?? []) as number[];
  return radii.length === 0 ? null : [mmFromMetres(Math.min(...radii)), mmFromMetres(Math.max(...radii))];
}

/** Draws and reads at once, as the canvas is empty again after the frame. */
function readPicture(viewer: Viewer): Picture {
  const gl = viewer.renderer.getContext();
  viewer.draw();
  const pixels = new Uint8Array(4 * gl.drawingBufferWidth * gl.drawingBufferHeight);
  gl.readPixels(0, 0, gl.drawingBufferWidth, gl.drawingBufferHeight, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
  const words = new Uint32Array(pixels.buffer);
  let checksum = 0;
  for (const word of words) checksum = (Math.imul(checksum, 31) + word) | 0;
  return { colours: new Set(words).size, checksum, isLost: gl.isContextLost() };
}
