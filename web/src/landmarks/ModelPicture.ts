// The little picture beside the instruction: the model at rest, seen from the front, with the wanted point lit.
import { Box3, Mesh, MeshStandardMaterial, OrthographicCamera, Scene, Vector3 } from "three";
import type { ModelSide } from "../api/types";
import { addLights } from "../viewer/lights";
import { Snapshot } from "../viewer/Snapshot";
import { surfacePosition } from "../viewer/lines/surfacePoints";
import type { Part, Viewer } from "../viewer/Viewer";
import type { LandmarksSlice } from "./state";

/** The model's mesh; null until it is there. */
export interface RestingModel {
  readonly mesh: Mesh | null;
  readonly side: ModelSide | null;
  /** Rest positions as they are in the file: body frame, metres. */
  restVertex(vertex: number): Vector3;
}

type Shown = Pick<LandmarksSlice, "active">;

const MARGIN = 1.08;

export class ModelPicture implements Part<Shown> {
  private readonly snapshot: Snapshot;
  private readonly camera = new OrthographicCamera();
  private readonly clay = new MeshStandardMaterial({ roughness: 0.8, metalness: 0 });
  private scene: Scene | null = null;
  private stood: Mesh | null = null; // that the scene shows
  private painted = "";

  constructor(
    private readonly viewer: Viewer,
    private readonly torso: RestingModel,
    private readonly canvas: HTMLCanvasElement,
    private readonly light: HTMLElement,
  ) {
    this.snapshot = new Snapshot(viewer.renderer, 360);
  }

  update(state: Shown): void {
    const wanted = this.torso.side?.landmarks.find((entry) => entry.name === state.active);
    this.light.hidden = !wanted;
    if (!wanted || !this.torso.mesh) return;
    const look = this.viewer.palette.clay.getHexString() + this.viewer.palette.canvas.getHexString();
    if (look !== this.painted || this.stood !== this.torso.mesh) this.paint(look);
    const at = new Vector3();
    const vertexAt = (vertex: number, target: Vector3): Vector3 => target.copy(this.torso.restVertex(vertex));
    surfacePosition(wanted, this.torso.mesh.geometry.index!.array, vertexAt, at, new Vector3());
    at.project(this.camera);
    this.light.style.left = `${(50 * (at.x + 1)).toFixed(2)}%`;
    this.light.style.top = `${(50 * (1 - at.y)).toFixed(2)}%`;
  }

  private paint(look: string): void {
    this.painted = look;
    if (!this.scene || this.stood !== this.torso.mesh) this.scene = this.stage();
    this.stood = this.torso.mesh;
    this.clay.color.copy(this.viewer.palette.clay);
    this.snapshot.draw(this.scene, this.camera, this.viewer.palette.canvas, this.canvas);
  }

  private stage(): Scene {
    const scene = new Scene();
    const { geometry } = this.torso.mesh!;
    const still = new Mesh(geometry, this.clay); // without the skin and with all shapes at zero: at rest
    scene.add(still);
    addLights(scene, this.camera);
    const box = new Box3().setFromBufferAttribute(geometry.attributes.position as never);
    const middle = box.getCenter(new Vector3());
    const half = (MARGIN * Math.max(...box.getSize(new Vector3()).toArray().slice(0, 2))) / 2;
    Object.assign(this.camera, { left: -half, right: half, top: half, bottom: -half, near: 0.1, far: 10 });
    this.camera.position.set(middle.x, middle.y, middle.z + 3);
    this.camera.updateProjectionMatrix();
    this.camera.updateMatrixWorld();
    return scene;
  }
}
