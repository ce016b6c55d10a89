// Lower left on the stage: the place that is asked about, on the model at rest, as near as on the scan.
import { Mesh, MeshStandardMaterial, PerspectiveCamera, Scene, Vector3 } from "three";
import type { RestingModel } from "../landmarks/ModelPicture";
import { el } from "../ui/dom";
import { addLights } from "../viewer/lights";
import { surfacePosition } from "../viewer/lines/surfacePoints";
import { Snapshot } from "../viewer/Snapshot";
import type { Palette } from "../viewer/palette";
import type { Viewer } from "../viewer/Viewer";
import type { Check } from "./state";
import * as text from "./text";

const SIZE = 216; // pixels
const AWAY = 0.42; // metres: with this lens the breast around a nipple is seen, so that one knows where one is
const LENS = 26; // degrees

export class ModelInset {
  readonly element: HTMLElement;
  private readonly canvas = el("canvas", {});
  private readonly snapshot: Snapshot;
  private readonly clay = new MeshStandardMaterial({ roughness: 0.8, metalness: 0 });
  private readonly camera = new PerspectiveCamera(LENS, 1, 0.05, 10);
  private readonly dot: HTMLElement;
  private painted: Palette | null = null;

  constructor(private readonly viewer: Viewer, private readonly torso: RestingModel) {
    this.snapshot = new Snapshot(viewer.renderer, SIZE);
    this.dot = el("span", { class: "check-dot" });
    this.element = el("figure", { class: "check-inset", hidden: true }, el("div", { class: "check-picture" }, this.canvas, this.dot), el("figcaption", { class: "small" }, text.checks.inset));
  }

  /** The theme is another one than when it was painted. */
  get isOld(): boolean {
    return !this.element.hidden && this.painted !== this.viewer.palette;
  }

  show(check: Check | null): void {
    const { mesh } = this.torso;
    this.element.hidden = !check || !mesh;
    if (!check || !mesh) return;
    const scene = new Scene();
    scene.add(new Mesh(mesh.geometry, this.clay)); // without the skin and with all shapes at zero: at rest
    this.painted = this.viewer.palette;
    this.clay.color.copy(this.painted.clay);
    const [at, normal] = [new Vector3(), new Vector3()];
    surfacePosition(check.point, mesh.geometry.index!.array, (vertex, target) => target.copy(this.torso.restVertex(vertex)), at, normal);
    this.camera.position.copy(at).addScaledVector(normal, AWAY);
    this.camera.lookAt(at);
    this.camera.updateMatrixWorld();
    this.camera.clear(); // of the lamps of the point before
    addLights(scene, this.camera);
    this.snapshot.draw(scene, this.camera, this.painted.canvas, this.canvas);
  }
}
