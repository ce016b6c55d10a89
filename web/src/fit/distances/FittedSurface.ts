// The fitted surface as the service wrote it (fitted.ply): what the distances belong to, vertex by vertex, and the
// only form in which a refined fit exists.  It takes the posed rig's place when the fit is at rest.
import { BufferAttribute, type BufferGeometry, type Color, DataTexture, DoubleSide, FloatType, FrontSide, LinearFilter, Mesh, MeshLambertMaterial, RGBAFormat, type Vector3 } from "three";
import { acceleratedRaycast, MeshBVH } from "three-mesh-bvh";
import type { Frame } from "../../api/types";
import type { ScanSlice } from "../../scan/state";
import { isUnit, metresFromMm, mmFrom } from "../../ui/units";
import { extent } from "../../viewer/extent";
import type { Surface } from "../../viewer/picking";
import { lidMaterial, tintLid, withLids } from "../../viewer/openings";
import { bringNearer, depthMaterial, GLASS, MODEL_SHARE, ORDER, pushAway } from "../../viewer/overlaid";
import type { ViewSlice } from "../../viewer/state";
import { geometryOf, type Triangles } from "../../viewer/ply";
import { nearestNormal } from "../../viewer/lines/surfacePoints";
import { type Part, type Viewer, viewFromScan } from "../../viewer/Viewer";
import { colourOf, SCALE_MM } from "./distances";
import { type Shown, showsFittedSurface } from "../state";

type State = Shown & Pick<ViewSlice & ScanSlice, "overlay" | "scan">;

const STEPS = 501; // of the lookup; 0.02 mm each

export class FittedSurface implements Part<State>, Surface {
  mesh: Mesh<BufferGeometry, MeshLambertMaterial[]> | null = null;
  private read: Triangles | null = null;
  private coloured: Float32Array | null = null;
  private readonly plain = new MeshLambertMaterial({ transparent: true });
  private readonly map = distanceMaterial();
  private readonly lid = lidMaterial();
  private lids: { show: (shown: boolean) => void } | null = null;
  private readonly solid = new MeshLambertMaterial({ side: FrontSide });
  private readonly depthOnly = depthMaterial(false);
  private readonly trueDepth = depthMaterial(true);
  private passes: Mesh[] = [];
  private isOver = false;

  constructor(
    private readonly viewer: Viewer,
    private readonly onReady: (error: unknown) => void,
  ) {
    viewer.beforeFrame.add(() => {
      bringNearer([this.plain, this.map.material, this.depthOnly], this.isOver, viewer.depthUnits);
      pushAway(this.solid, viewer.depthUnits);
    });
  }

  get bvh(): MeshBVH | null {
    return (this.mesh?.geometry.boundsTree as MeshBVH | undefined) ?? null;
  }

  /** Unit vector out of the surface nearest to a point (scan's frame, metres). */
  normalAt(point: Vector3): Vector3 | null {
    return this.mesh ? nearestNormal(this.mesh.geometry, point) : null;
  }

  update(state: State): void {
    const triangles = state.fit?.surface ?? null;
    if (triangles !== this.read) {
      this.load(triangles, state.fit?.result?.scan.unit);
      if (this.mesh && state.scan?.mesh === null) this.standAlone(this.mesh.geometry, state.scan.frame);
    }
    if (!this.mesh) return;
    const distances = state.fit?.distances ?? null;
    if (distances && distances !== this.coloured) this.colour(this.mesh.geometry, distances);
    const hasMap = state.showDistances && distances !== null;
    this.mesh.material = [hasMap ? this.map.material : this.plain, this.lid];
    this.map.unknown.copy(this.viewer.palette.unknown);
    const isAlone = state.overlay !== "both";
    this.isOver = !isAlone;
    const { isGlass } = this.viewer;
    for (const pass of this.passes) pass.visible = !isAlone && !(isGlass && pass.material === this.solid);
    this.plain.opacity = isGlass ? GLASS : isAlone ? 1 : MODEL_SHARE;
    this.plain.side = isAlone && !isGlass ? DoubleSide : FrontSide;
    for (const clay of [this.plain, this.solid]) clay.color.copy(this.viewer.palette.clay);
    tintLid(this.lid, hasMap ? this.viewer.palette.unknown : this.viewer.palette.clay); // no distance is known of a lid
    this.lids?.show(isAlone && !isGlass);
    this.mesh.visible = showsFittedSurface(state) && state.overlay !== "scan";
    this.viewer.invalidate();
  }

  private load(triangles: Triangles | null, unit: string | undefined): void {
    this.read = triangles;
    this.coloured = null;
    if (this.mesh) {
      this.mesh.removeFromParent();
      this.mesh.geometry.dispose();
      this.mesh = null;
    }
    if (!triangles) return;
    try {
      if (!isUnit(unit)) throw new Error(`the surface has the unknown unit ${unit}`);
      const geometry = geometryOf(triangles, metresFromMm(mmFrom(1, unit)));
      geometry.computeVertexNormals();
      geometry.boundsTree = new MeshBVH(geometry, { indirect: true });
      this.lids = withLids(geometry);
      this.mesh = new Mesh(geometry, [this.plain, this.lid]);
      this.mesh.name = "fitted";
      this.mesh.renderOrder = ORDER.model;
      this.passes = ([[this.solid, ORDER.farBefore], [this.depthOnly, ORDER.modelDepth], [this.trueDepth, ORDER.restoreModel]] as const).map(([material, order]) => {
        const pass = new Mesh(geometry, material);
        pass.renderOrder = order;
        pass.raycast = () => undefined;
        return pass;
      });
      this.mesh.add(...this.passes);
      this.mesh.raycast = acceleratedRaycast;
      this.viewer.body.add(this.mesh);
    } catch (error) {
      this.onReady(error);
    }
  }

  /** Without a scan nothing else says where the body stands. */
  private standAlone(geometry: BufferGeometry, frame: Frame): void {
    this.viewer.stand(frame, extent(geometry.attributes.position!.array, viewFromScan(frame)));
    this.viewer.lookFrom("front", false);
  }

  private colour(geometry: BufferGeometry, distances: Float32Array): void {
    const count = geometry.attributes.position!.count;
    if (distances.length !== count) throw new Error(`${distances.length} distances for ${count} vertices`);
    // Two numbers for each vertex: the distance, and whether there is one (NaN would spoil the whole triangle).
    const pairs = new Float32Array(2 * count);
    distances.forEach((value, i) => pairs.set(Number.isNaN(value) ? [0, 0] : [value, 1], 2 * i));
    geometry.setAttribute("signedDistance", new BufferAttribute(pairs, 2));
    this.coloured = distances;
  }
}

function lookup(): DataTexture {
  const texels = new Float32Array(4 * STEPS);
  for (let i = 0; i < STEPS; i += 1) texels.set([...colourOf(SCALE_MM * ((2 * i) / (STEPS - 1) - 1)), 1], 4 * i);
  const texture = new DataTexture(texels, STEPS, 1, RGBAFormat, FloatType);
  texture.magFilter = texture.minFilter = LinearFilter;
  texture.needsUpdate = true;
  return texture;
}

/** Colours each pixel, not each vertex, by its distance: the scale's steps stay sharp on large triangles. */
function distanceMaterial(): { material: MeshLambertMaterial; unknown: Color } {
  const material = new MeshLambertMaterial({ side: DoubleSide, color: 0xffffff });
  const unknown = material.color.clone();
  material.onBeforeCompile = (shader) => {
    Object.assign(shader.uniforms, { scale: { value: lookup() }, unknown: { value: unknown } });
    shader.vertexShader = shader.vertexShader
      .replace("#include <common>", "#include <common>\nattribute vec2 signedDistance;\nvarying vec2 vDistance;")
      .replace("#include <begin_vertex>", "#include <begin_vertex>\nvDistance = signedDistance;");
    shader.fragmentShader = shader.fragmentShader
      .replace("#include <common>", "#include <common>\nuniform sampler2D scale;\nuniform vec3 unknown;\nvarying vec2 vDistance;")
      .replace(
        "#include <color_fragment>",
        `#include <color_fragment>
        float along = clamp(0.5 + vDistance.x / ${(2 * SCALE_MM).toFixed(1)}, 0.0, 1.0);
        diffuseColor.rgb = vDistance.y > 0.999 ? texture2D(scale, vec2(along, 0.5)).rgb : unknown;`,
      );
  };
  return { material, unknown };
}
