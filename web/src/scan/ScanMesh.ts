// The scan: matte grey or its own colours, the inside and the rims of holes darker, ready for picking by BVH.
import { BufferAttribute, BufferGeometry, DoubleSide, LineBasicMaterial, LineSegments, Mesh, MeshBasicMaterial, MeshLambertMaterial, type Texture, type Vector3 } from "three";
import { acceleratedRaycast, type MeshBVH } from "three-mesh-bvh";
import { extent } from "../viewer/extent";
import { firstMesh, readGltf } from "../viewer/gltf";
import { nextTask } from "../viewer/nextTask";
import type { Surface } from "../viewer/picking";
import { depthMaterial, GLASS, ORDER, wipesDepth } from "../viewer/overlaid";
import type { ViewSlice } from "../viewer/state";
import { nearestNormal } from "../viewer/lines/surfacePoints";
import { type Viewer, viewFromScan } from "../viewer/Viewer";
import { type Body, cutByService, indexOf, NOTHING_CUT, type Outline, partOf, type ScanParts, setTree } from "./body";
import { knownBody, knownOutline, searchScan } from "./bodySearch";
import { type Crop, croppedFaces, type Crops, cropsOf, NO_CROPS } from "./crop";
import { place } from "./place";
import type { ScanSlice } from "./state";

const BEHIND = 0.0025; // metres that the scan steps back for the model: as much as both are sure of
const VEIL = 0.5; // of the grey over what was cut away, when it is shown
const INSIDE = 0.5; // brightness of a triangle that is seen from behind
const RELIEF = { fold: 0.42, ridge: 0.16 }; // of the brightness, where the surface bends most

type Shown = Pick<ScanSlice & ViewSlice, "scan" | "showColours" | "showLoose" | "showRelief" | "overlay"> & Partial<Pick<ScanSlice, "pointedCut">>;

export class ScanMesh implements Surface {
  mesh: Mesh<BufferGeometry, MeshLambertMaterial> | null = null;
  private texture: Texture | null = null; // its own, whether it is shown or not
  private wanted: ArrayBuffer | null = null;
  private stands: object | null = null;
  private crops: Crops = NO_CROPS;
  private borders: LineSegments | null = null;
  private depth: Mesh | null = null; // again, after a model that lies over it
  private cut: { readonly of: "all" | Crop; readonly mesh: Mesh } | null = null; // a veil over what was cut away
  private found: Body | null = null;
  private readonly relief = { value: 0 }; // how much of it is seen, for the shader
  // One of each for all scans: with each new material its program would be made again.
  private readonly skin = skinMaterial(this.relief);
  private readonly rim = new LineBasicMaterial();
  private readonly veil = new MeshBasicMaterial({ transparent: true, opacity: VEIL, depthWrite: false, side: DoubleSide, polygonOffset: true, polygonOffsetFactor: -1, polygonOffsetUnits: -1 });
  private readonly lateDepth = depthMaterial(true, DoubleSide);
  private readonly rims: Record<"whole" | "body", BufferAttribute | null> = { whole: null, body: null };
  /** null while there is no scan */
  parts: ScanParts | null = null;
  /** Nothing of it is still being looked for: it stands where it will stand. */
  isSettled = false;

  constructor(
    private readonly viewer: Viewer,
    /** Called when another scan can be picked on (null), or with the reason why it cannot be drawn. */
    private readonly onReady: (error: unknown) => void,
    /** Called when this file's scan has a table or loose pieces. */
    private readonly onLoose: (file: ArrayBuffer) => void,
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

  faceOf(face: number): number {
    return this.mesh && this.mesh.geometry === this.parts?.body ? (this.found?.part?.faces[face] ?? -1) : face;
  }

  /** `hasModel`: something of the model is on the stage as well. */
  update(state: Shown, hasModel: boolean): void {
    const bytes = state.scan?.mesh ?? null;
    if (bytes !== this.wanted) {
      this.wanted = bytes;
      this.crops = cropsOf(state.scan);
      this.clear();
      if (bytes) void this.load(bytes, state, hasModel);
    }
    if (this.mesh && bytes && cropsOf(state.scan) !== this.crops) {
      this.crops = cropsOf(state.scan);
      void this.findPatient(bytes, state, this.parts!.whole);
    }
    if (this.mesh) this.paint(this.mesh, state, hasModel);
  }

  private clear(): void {
    this.mesh?.removeFromParent();
    this.texture?.dispose(); // shown or not
    if (this.skin.map) this.skin.needsUpdate = true;
    this.skin.map = null;
    this.parts?.whole.dispose();
    this.parts?.body?.dispose();
    this.borders?.geometry.dispose();
    this.mesh = null;
    this.texture = null;
    this.borders = null;
    this.depth = null;
    this.dropVeil();
    this.stands = null;
    this.found = null;
    this.parts = null;
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
      this.borders = new LineSegments(new BufferGeometry(), this.rim);
      const whole = this.mesh.geometry;
      this.rims.whole = this.rims.body = null;
      this.parts = { whole, drawable: null, body: null };
      const [outline, known] = [knownOutline(bytes), knownBody(bytes, this.crops)];
      if (outline) this.takeOutline(outline);
      if (outline && known) this.take(known);
      this.borders.raycast = () => undefined;
      this.depth = new Mesh(whole, this.lateDepth);
      this.depth.renderOrder = ORDER.restore;
      this.depth.raycast = () => undefined;
      wipesDepth(this.depth);
      this.mesh.add(this.borders, this.depth);
      this.viewer.body.add(this.mesh);
      this.paint(this.mesh, state, hasModel);
      if (!this.viewer.keepsPose) this.viewer.lookFrom("front", false);
      this.viewer.keepsPose = false;
      if (outline) this.onReady(null);
      if (outline && known) this.isSettled = true;
      else {
        await nextTask();
        if (bytes === this.wanted) await this.findPatient(bytes, state, whole);
      }
    } catch (error) {
      this.onReady(error);
    }
  }

  /** The scan is seen and can be worked on meanwhile. */
  private async findPatient(bytes: ArrayBuffer, { scan }: Shown, whole: BufferGeometry): Promise<void> {
    const { crops } = this;
    const wasKnown = this.found !== null; // the body is shown already
    this.isSettled = false;
    const { eye, target } = this.viewer.pose;
    const known = whole.boundsTree ? knownBody(bytes, crops) : null;
    const search = known ? null : searchScan(bytes, whole, scan ? cutByService(scan.info) : NOTHING_CUT, crops);
    if (search && !whole.boundsTree) {
      const outline = await search.outline;
      if (bytes !== this.wanted) return;
      this.takeOutline(outline);
      this.onReady(null);
    }
    const body = known ?? (await search!.body);
    if (bytes !== this.wanted || crops !== this.crops) return;
    if (body) this.take(body);
    this.isSettled = true;
    if (wasKnown || crops.length > 0) {
      queueMicrotask(() => this.onReady(null)); // what is known already is found while the view is being brought up to date
      return;
    }
    if (!body?.part) {
      if (body?.relief) this.onReady(null);
      return;
    }
    const now = this.viewer.pose;
    const isUntouched = now.eye.equals(eye) && now.target.equals(target);
    if (isUntouched) this.stands = null; // the body is centred; a view that was turned by hand stays
    this.onLoose(bytes);
    this.onReady(null);
    if (isUntouched) this.viewer.lookFrom("front", false);
  }

  /** From now on it can be picked on, and its rims are seen. */
  private takeOutline(outline: Outline): void {
    const { whole } = this.parts!;
    if (whole.boundsTree) return; // two searches began before either had ended
    setTree(whole, outline);
    this.rims.whole = new BufferAttribute(outline.rims, 3);
    this.showRims(this.mesh!.geometry === whole ? this.rims.whole : this.rims.body);
    this.viewer.invalidate();
  }

  private showRims(rims: BufferAttribute | null): void {
    if (!this.borders) return;
    this.borders.visible = rims !== null;
    if (rims) this.borders.geometry.setAttribute("position", rims);
  }

  private take(body: Body): void {
    const { whole, body: before } = this.parts!;
    before?.dispose();
    this.dropVeil();
    this.found = body;
    if (body.relief) whole.setAttribute("relief", new BufferAttribute(body.relief, 1, true)); // before the patient's part, which shares it
    this.parts = { whole, drawable: body.drawable, body: body.part && partOf(whole, body.part) };
    this.rims.body = body.part && new BufferAttribute(body.part.rims, 3);
  }

  private dropVeil(): void {
    this.cut?.mesh.removeFromParent();
    this.cut?.mesh.geometry.dispose();
    this.cut = null;
  }

  /** All of what was cut away, or the cut that is pointed at, is seen as such. */
  private showVeil(mesh: Mesh, of: "all" | Crop | null): void {
    const { whole, drawable, body } = this.parts!;
    if (this.cut?.of === of || (!this.cut && of === null)) return;
    this.dropVeil();
    if (of === null || !drawable || !body) return;
    const index = whole.index!.array;
    const faces = of === "all" ? drawable.isSkin.map((is) => 1 - is) : croppedFaces(whole.attributes.position!.array, index, [of]);
    const geometry = new BufferGeometry().setAttribute("position", whole.attributes.position!);
    geometry.setIndex(new BufferAttribute(indexOf(index, faces), 1)).boundingSphere = whole.boundingSphere;
    const veil = new Mesh(geometry, this.veil);
    veil.raycast = () => undefined;
    mesh.add(veil);
    this.cut = { of, mesh: veil };
  }

  /** Her alone, or all that was scanned. */
  private showPart(mesh: Mesh<BufferGeometry, MeshLambertMaterial>, { showLoose, pointedCut = null }: Shown): void {
    const { whole, body } = this.parts!;
    const isHer = body !== null && !showLoose;
    mesh.geometry = isHer ? body : whole;
    if (this.depth) this.depth.geometry = mesh.geometry;
    this.showVeil(mesh, showLoose ? "all" : pointedCut === null ? null : (this.crops[pointedCut] ?? null));
    this.showRims(isHer ? this.rims.body : this.rims.whole);
  }

  private paint(mesh: Mesh<BufferGeometry, MeshLambertMaterial>, state: Shown, hasModel: boolean): void {
    const { palette } = this.viewer;
    this.showPart(mesh, state);
    const frame = state.scan?.frame;
    if (frame && frame !== this.stands) {
      this.stands = frame;
      this.viewer.stand(frame, extent(mesh.geometry.attributes.position!.array, viewFromScan(frame), this.found?.part?.index));
    }
    // Beside the clay the scan is grey: skin on skin could not be distinguished.
    const hasColours = this.texture !== null || mesh.geometry.hasAttribute("color");
    const own = hasColours && state.showColours && state.scan?.info.colours !== "none" && !(hasModel && state.overlay === "both");
    const material = mesh.material;
    const map = own ? this.texture : null;
    const hasVertexColours = own && mesh.geometry.hasAttribute("color");
    if (material.map !== map || material.vertexColors !== hasVertexColours) {
      material.map = map;
      material.vertexColors = hasVertexColours;
      material.needsUpdate = true;
    }
    const { isGlass } = this.viewer;
    if (material.transparent !== isGlass) {
      material.transparent = isGlass;
      material.needsUpdate = true;
    }
    material.opacity = isGlass ? GLASS : 1;
    if (own) material.color.set(0xffffff);
    else material.color.copy(palette.scan);
    this.relief.value = state.showRelief && this.found?.relief ? 1 : 0;
    this.rim.color.copy(palette["scan-edge"]);
    this.veil.color.copy(palette["scan-edge"]);
    if (this.depth) this.depth.visible = hasModel && state.overlay === "both";
    mesh.visible = !(hasModel && state.overlay === "model");
    this.viewer.invalidate();
  }
}

function skinMaterial(relief: { value: number }): MeshLambertMaterial {
  const material = new MeshLambertMaterial({ side: DoubleSide });
  // Behind the model where both lie on one place: the eye then sees the clay and no flicker between the two.
  material.polygonOffset = true;
  material.onBeforeCompile = (shader) => {
    shader.uniforms.reliefShown = relief;
    shader.vertexShader = shader.vertexShader
      .replace("#include <common>", "#include <common>\nattribute float relief;\nvarying float vRelief;")
      .replace("#include <begin_vertex>", "#include <begin_vertex>\nvRelief = relief;");
    shader.fragmentShader = shader.fragmentShader
      .replace("#include <common>", "#include <common>\nuniform float reliefShown;\nvarying float vRelief;")
      .replace(
        "#include <color_fragment>",
        `#include <color_fragment>
        float bend = reliefShown * (2.0 * vRelief - 256.0 / 255.0);
        diffuseColor.rgb *= 1.0 + bend * (bend < 0.0 ? ${RELIEF.fold} : ${RELIEF.ridge});
        if (!gl_FrontFacing) diffuseColor.rgb *= ${INSIDE};`,
      );
  };
  return material;
}

/** The mesh as we want it, whatever material it came with. */
function dress(read: Mesh, material: MeshLambertMaterial): Mesh<BufferGeometry, MeshLambertMaterial> {
  const geometry = read.geometry;
  place(geometry, read.matrixWorld);
  if (!geometry.index) geometry.setIndex([...Array(geometry.attributes.position!.count).keys()]);
  if (!geometry.hasAttribute("normal")) geometry.computeVertexNormals();
  const mesh = new Mesh(geometry, material);
  mesh.name = "scan";
  mesh.raycast = acceleratedRaycast;
  return mesh;
}
