// The rigged model that the fit was made with: loaded once, then posed by whatever the service says, live or replayed.
// Over the scan it is translucent clay, see viewer/overlaid.ts.  A first pass fills the depth only, so that it never shows
// its own inside.
import { DoubleSide, FrontSide, type Material, type Mesh, MeshStandardMaterial, type Object3D, SkinnedMesh, Vector3 } from "three";
import type { Model, ModelSide, NodePose } from "../api/types";
import type { ScanSlice } from "../scan/state";
import { disposeTree, readGltf } from "../viewer/gltf";
import { lidMaterial, tintLid, withLids } from "../viewer/openings";
import { bringNearer, depthMaterial, GLASS, MODEL_SHARE, ORDER } from "../viewer/overlaid";
import type { ViewSlice } from "../viewer/state";
import type { VertexAt } from "../viewer/lines/surfacePoints";
import type { Part, Viewer } from "../viewer/Viewer";
import type { DualQuaternionSkin } from "./dualQuaternions";
import { modelOf, type Shown, shownPoses, showsFittedSurface } from "./state";

type State = Shown & Pick<ViewSlice & ScanSlice, "overlay" | "scan">;

export class TorsoModel implements Part<State> {
  mesh: SkinnedMesh | null = null;
  private skin: DualQuaternionSkin | null = null; // that is shown in its place where the rig asks for it
  private root: Object3D | null = null;
  private readonly nodes = new Map<string, Object3D>();
  private wanted: Model | null = null;
  private model: Model | null = null; // that the mesh is of
  private applied: readonly NodePose[] | null = null;
  private readonly clay = new MeshStandardMaterial({ roughness: 0.75, metalness: 0, transparent: true, side: FrontSide });
  private readonly depthOnly = depthMaterial(false);
  private readonly trueDepth = depthMaterial(true);
  private readonly lid = lidMaterial();
  private lids: { show: (shown: boolean) => void } | null = null;
  private restoring: Object3D | null = null;
  private isOver = false;

  constructor(
    private readonly viewer: Viewer,
    private readonly onReady: (error: unknown) => void,
  ) {
    viewer.beforeFrame.add(() => bringNearer([this.clay, this.depthOnly], this.isOver, viewer.depthUnits));
  }

  update(state: State): void {
    const model = state.scan && modelOf(state); // without a body nobody looks at it
    if (model && model !== this.wanted) {
      this.wanted = model;
      void this.load(model);
    }
    if (!this.mesh || !this.root) return;
    const poses = model === this.model ? shownPoses(state) : null;
    if (model !== this.model) this.applied = null;
    if (poses && poses !== this.applied) this.apply(poses);
    this.root.visible = poses !== null && state.overlay !== "scan" && !showsFittedSurface(state);
    const isAlone = state.overlay !== "both";
    this.isOver = !isAlone;
    if (this.restoring) this.restoring.visible = !isAlone;
    const { isGlass } = this.viewer;
    this.clay.opacity = isGlass ? GLASS : isAlone ? 1 : MODEL_SHARE;
    this.clay.side = isAlone && !isGlass ? DoubleSide : FrontSide;
    this.clay.color.copy(this.viewer.palette.clay);
    tintLid(this.lid, this.viewer.palette.clay);
    this.lids?.show(isAlone && !isGlass);
    this.viewer.invalidate();
  }

  /** Sets nodes by name, in glTF's own words; a field that is absent stays as it is. */
  apply(poses: readonly NodePose[]): void {
    for (const pose of poses) {
      const node = this.nodes.get(pose.name);
      if (!node) throw new Error(`the service posed an unknown node: ${pose.name}`);
      if (pose.translation) node.position.fromArray(pose.translation); // metres
      if (pose.rotation) node.quaternion.fromArray(pose.rotation); // x y z w
      if (pose.scale) node.scale.fromArray(pose.scale);
      pose.weights?.forEach((weight, shape) => (this.mesh!.morphTargetInfluences![shape] = weight));
    }
    this.applied = poses;
    this.root!.updateMatrixWorld(true);
    this.skin?.pose();
  }

  /** Posed vertices in the scan's frame, metres; null until a pose is known. */
  get vertexAt(): VertexAt | null {
    const mesh = this.mesh;
    if (!mesh || !this.applied) return null;
    const posed = this.skin ?? mesh;
    return (vertex, target) => posed.getVertexPosition(vertex, target).applyMatrix4(mesh.matrix);
  }

  private async load(model: Model): Promise<void> {
    try {
      const { scene } = await readGltf(model.glb);
      const blended = model.side.skinning === "dual_quaternion" ? (await import("./dualQuaternions")).DualQuaternionSkin : null;
      if (model !== this.wanted) return;
      let mesh: SkinnedMesh | null = null;
      this.nodes.clear();
      scene.traverse((node) => {
        this.nodes.set(node.name, node);
        if (node instanceof SkinnedMesh) mesh = node;
      });
      this.adopt(scene, mesh, blended);
      this.model = model;
      this.applied = null;
      this.onReady(null);
    } catch (error) {
      this.onReady(error);
    }
  }

  private adopt(scene: Object3D, mesh: SkinnedMesh | null, blended: typeof DualQuaternionSkin | null): void {
    if (!mesh) throw new Error("no skinned mesh");
    if (this.root) disposeTree(this.root);
    const { skeleton, bindMatrix, morphTargetInfluences } = mesh;
    this.skin = blended && new blended(mesh);
    const { geometry } = this.skin ?? mesh;
    this.lids = withLids(geometry);
    const pass = (material: Material | Material[]): Mesh => {
      if (this.skin) return this.skin.shown(material);
      const made = new SkinnedMesh(geometry, material);
      made.bind(skeleton, bindMatrix);
      made.morphTargetInfluences = morphTargetInfluences!;
      return made;
    };
    const passes = [pass([this.clay, this.lid]), pass(this.depthOnly), pass(this.trueDepth)] as const;
    const [shown, depth, restoring] = passes;
    mesh.visible = false;
    depth.renderOrder = ORDER.modelDepth;
    shown.renderOrder = ORDER.model;
    restoring.renderOrder = ORDER.restoreModel;
    this.restoring = restoring;
    for (const each of passes) {
      each.frustumCulled = false; // its box would have to be posed on the CPU for each picture
      each.raycast = () => undefined;
    }
    mesh.parent!.add(...passes);
    scene.visible = false;
    this.mesh = mesh;
    this.root = scene;
    this.viewer.body.add(scene);
  }

  get side(): ModelSide | null {
    return this.model?.side ?? null;
  }

  /** Rest positions as they are in the file: body frame, metres. */
  restVertex(vertex: number): Vector3 {
    return new Vector3().fromBufferAttribute(this.mesh!.geometry.attributes.position!, vertex);
  }
}
