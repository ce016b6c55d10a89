// The scan: matte grey or its own colours, the inside and the rims of holes darker, ready for picking by BVH.
import { BufferAttribute, BufferGeometry, DoubleSide, LineBasicMaterial, LineSegments, Mesh, MeshLambertMaterial, type Object3D, type Texture, type Vector3 } from "three";
import { acceleratedRaycast, MeshBVH } from "three-mesh-bvh";
import { extent } from "../viewer/extent";
import { firstMesh, readGltf } from "../viewer/gltf";
import { nextTask } from "../viewer/nextTask";
import type { Surface } from "../viewer/picking";
import { depthMaterial, GLASS, ORDER, wipesDepth } from "../viewer/overlaid";
import type { ViewSlice } from "../viewer/state";
import { nearestNormal } from "../viewer/lines/surfacePoints";
import { type Viewer, viewFromScan } from "../viewer/Viewer";
import { type Crop, croppedFaces, type Crops, cropsOf, leftOver, NO_CROPS, triangles } from "./crop";
import { place } from "./place";
import type { ScanSlice } from "./state";
import { treeOf } from "./treeSearch";

const BEHIND = 0.0025; // metres that the scan steps back for the model: as much as both are sure of
const INSIDE = 0.5; // brightness of a triangle that is seen from behind
const RIDGE = 1.16; // brightness of a ridge, which a grey scan's shades have as white (rendering/folds.py)

type Shown = Pick<ScanSlice & ViewSlice, "scan" | "showColours" | "showLoose" | "showRelief" | "overlay"> & Partial<Pick<ScanSlice, "pointedCut">>;

export class ScanMesh implements Surface {
  /** The body: without tables and loose pieces, and what is cut away by hand. */
  mesh: Mesh<BufferGeometry, MeshLambertMaterial> | null = null;
  private texture: Texture | null = null; // its own, whether it is shown or not
  private wanted: ArrayBuffer | null = null;
  private stands: object | null = null;
  private crops: Crops = NO_CROPS;
  private body = new Uint32Array(); // corners of the body's triangles, before anything is cut away
  private rest = new Uint32Array(); // and of all others
  private rims: LineSegments | null = null;
  private depth: Mesh | null = null; // again, after a model that lies over it
  private gone: { readonly of: "all" | Crop; readonly mesh: Mesh } | null = null; // what was cut away, as it is looked at
  // One of each for all scans: with each new material its program would be made again.
  private readonly skin = skinMaterial();
  private readonly rim = new LineBasicMaterial();
  private readonly loose = new MeshLambertMaterial({ side: DoubleSide });
  private readonly lateDepth = depthMaterial(true, DoubleSide);
  /** It can be picked on, as it is wanted by now. */
  isSettled = false;

  constructor(
    private readonly viewer: Viewer,
    /** Called when another scan can be picked on (null), or with the reason why it cannot be drawn. */
    private readonly onReady: (error: unknown) => void,
  ) {
    viewer.beforeFrame.add(() => {
      for (const each of [this.skin, this.lateDepth]) each.polygonOffsetUnits = BEHIND * viewer.depthUnits;
    });
  }

  get bvh(): MeshBVH | null {
    return (this.mesh?.geometry.boundsTree as MeshBVH | undefined) ?? null;
  }

  /** Unit vector out of the surface nearest to a point (scan's frame, metres); null before the scan is there. */
  normalAt(point: Vector3): Vector3 | null {
    return this.mesh ? nearestNormal(this.mesh.geometry, point) : null;
  }

  /** `hasModel`: something of the model is on the stage as well. */
  update(state: Shown, hasModel: boolean): void {
    const bytes = state.scan?.mesh ?? null;
    const crops = cropsOf(state.scan);
    if (bytes !== this.wanted) {
      this.wanted = bytes;
      this.crops = crops;
      this.clear();
      if (bytes) void this.load(bytes, state, hasModel);
    }
    if (this.mesh && bytes && crops !== this.crops) {
      this.crops = crops;
      void this.cut(bytes, this.mesh).catch(this.onReady);
    }
    if (this.mesh) this.paint(this.mesh, state, hasModel);
  }

  private clear(): void {
    this.dropGone();
    this.mesh?.removeFromParent();
    this.mesh?.geometry.dispose();
    this.rims?.geometry.dispose();
    this.texture?.dispose(); // shown or not
    if (this.skin.map) this.skin.needsUpdate = true;
    this.skin.map = null;
    this.mesh = this.texture = this.rims = this.depth = this.stands = null;
    this.isSettled = false;
    this.viewer.invalidate();
  }

  private async load(bytes: ArrayBuffer, state: Shown, hasModel: boolean): Promise<void> {
    try {
      const { scene } = await readGltf(bytes);
      await nextTask(); // of a million triangles each of these steps takes as long as a task may
      if (bytes !== this.wanted) return; // another scan was asked for meanwhile
      const read = firstMesh(scene);
      if (!read) throw new Error("no mesh");
      scene.updateMatrixWorld(true);
      this.texture = (read.material as MeshLambertMaterial).map;
      this.mesh = dress(read, this.skin);
      const { geometry } = this.mesh;
      const all = Uint32Array.from(geometry.index!.array);
      const count = 3 * (state.scan?.info.body_triangles ?? all.length);
      [this.body, this.rest] = [all.subarray(0, count), all.subarray(count)];
      geometry.setIndex(new BufferAttribute(this.body, 1));
      this.rims = rimsIn(scene, this.rim);
      this.depth = new Mesh(geometry, this.lateDepth);
      this.depth.renderOrder = ORDER.restore;
      this.depth.raycast = () => undefined;
      wipesDepth(this.depth);
      this.mesh.add(this.depth, ...(this.rims ? [this.rims] : []));
      this.viewer.body.add(this.mesh);
      this.paint(this.mesh, state, hasModel);
      if (!this.viewer.keepsPose) this.viewer.lookFrom("front", false);
      this.viewer.keepsPose = false;
      await nextTask();
      if (bytes === this.wanted) await this.cut(bytes, this.mesh);
    } catch (error) {
      this.onReady(error);
    }
  }

  /** It is seen as it was, and can be worked on, until the tree of what is left is there. */
  private async cut(bytes: ArrayBuffer, { geometry }: Mesh): Promise<void> {
    const { crops, body, rims } = this;
    this.isSettled = false;
    const positions = geometry.attributes.position!.array;
    const index = leftOver(positions, body, crops);
    const tree = await treeOf(bytes, crops, positions, index);
    if (bytes !== this.wanted || crops !== this.crops) return;
    this.dropGone();
    geometry.dispose(); // what is left is sent anew
    geometry.setIndex(new BufferAttribute(index, 1));
    geometry.boundsTree = MeshBVH.deserialize(tree, geometry, { setIndex: false });
    if (rims) {
      const ends = rims.geometry.attributes.position!;
      const lines = Uint32Array.from({ length: (3 * ends.count) / 2 }, (_, i) => 2 * Math.floor(i / 3) + Math.min(i % 3, 1)); // triangles without area
      rims.geometry.setIndex([...triangles(lines, croppedFaces(ends.array, lines, crops), false)].filter((_, i) => i % 3 < 2));
    }
    this.isSettled = true;
    this.viewer.invalidate();
    queueMicrotask(() => this.onReady(null)); // what is known already is found while the view is being brought up to date
  }

  private dropGone(): void {
    this.gone?.mesh.removeFromParent();
    this.gone?.mesh.geometry.dispose();
    this.gone = null;
  }

  /** All of what is no body or was cut away, or the cut that is pointed at. */
  private showGone(mesh: Mesh, of: "all" | Crop | null): void {
    if ((this.gone?.of ?? null) === of) return;
    this.dropGone();
    if (of === null) return;
    const { attributes, boundingSphere } = mesh.geometry;
    const cut = croppedFaces(attributes.position!.array, this.body, of === "all" ? this.crops : [of]);
    const geometry = new BufferGeometry();
    for (const name of ["position", "normal"]) geometry.setAttribute(name, attributes[name]!);
    geometry.setIndex([...(of === "all" ? this.rest : []), ...triangles(this.body, cut, true)]).boundingSphere = boundingSphere;
    const shown = new Mesh(geometry, this.loose);
    shown.raycast = () => undefined;
    mesh.add(shown);
    this.gone = { of, mesh: shown };
  }

  private paint(mesh: Mesh<BufferGeometry, MeshLambertMaterial>, state: Shown, hasModel: boolean): void {
    const { palette, isGlass } = this.viewer;
    const { scan, showLoose, pointedCut = null } = state;
    this.showGone(mesh, showLoose ? "all" : pointedCut === null ? null : (this.crops[pointedCut] ?? null));
    if (scan && scan.frame !== this.stands) {
      this.stands = scan.frame;
      this.viewer.stand(scan.frame, extent(mesh.geometry.attributes.position!.array, viewFromScan(scan.frame), this.body));
    }
    const isShaded = mesh.userData.shaded === true; // its vertices have no colours, but shades of its shape
    const hasVertexColours = mesh.geometry.hasAttribute("color") && !isShaded;
    // Beside the clay the scan is grey: skin on skin could not be distinguished.
    const own = (this.texture !== null || hasVertexColours) && state.showColours && !(hasModel && state.overlay === "both");
    const relief = isShaded && state.showRelief;
    const look = { map: own ? this.texture : null, vertexColors: (own && hasVertexColours) || relief, transparent: isGlass };
    const { material } = mesh;
    if (material.map !== look.map || material.vertexColors !== look.vertexColors || material.transparent !== isGlass) material.needsUpdate = true;
    Object.assign(material, look);
    material.opacity = isGlass ? GLASS : 1;
    if (own) material.color.set(0xffffff);
    else material.color.copy(palette.scan).multiplyScalar(relief ? RIDGE : 1);
    this.rim.color.copy(palette["scan-edge"]);
    this.loose.color.copy(palette.scan).lerp(palette["scan-edge"], 0.5);
    if (this.depth) this.depth.visible = hasModel && state.overlay === "both";
    mesh.visible = !(hasModel && state.overlay === "model");
    this.viewer.invalidate();
  }
}

function skinMaterial(): MeshLambertMaterial {
  const material = new MeshLambertMaterial({ side: DoubleSide });
  // Behind the model where both lie on one place: the eye then sees the clay and no flicker between the two.
  material.polygonOffset = true;
  material.onBeforeCompile = (shader) => {
    shader.fragmentShader = shader.fragmentShader.replace("#include <color_fragment>", `#include <color_fragment>\nif (!gl_FrontFacing) diffuseColor.rgb *= ${INSIDE};`);
  };
  return material;
}

/** The mesh as we want it, whatever material it came with. */
function dress(read: Mesh, material: MeshLambertMaterial): Mesh<BufferGeometry, MeshLambertMaterial> {
  const { geometry, userData } = read;
  place(geometry, read.matrixWorld);
  if (!geometry.index) geometry.setIndex([...Array(geometry.attributes.position!.count).keys()]);
  if (!geometry.hasAttribute("normal")) geometry.computeVertexNormals();
  const mesh = new Mesh(geometry, material);
  Object.assign(mesh, { name: "scan", userData, raycast: acceleratedRaycast });
  return mesh;
}

/** The lines around its holes; null where the file has none. */
function rimsIn(scene: Object3D, material: LineBasicMaterial): LineSegments | null {
  let found: LineSegments | null = null;
  scene.traverse((node) => {
    if (!(node instanceof LineSegments)) return;
    const { geometry, matrixWorld } = node as LineSegments;
    found = new LineSegments(geometry.applyMatrix4(matrixWorld), material);
    found.raycast = () => undefined;
  });
  return found;
}
