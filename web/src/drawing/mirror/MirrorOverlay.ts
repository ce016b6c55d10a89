// The mirrored left breast on the right one: translucent, coloured by how far it stands out beyond it.
import { BufferAttribute, BufferGeometry, Color, Mesh, MeshLambertMaterial } from "three";
import { colourOf, SCALE_MM, SCANNER_MM } from "../../fit/distances/distances";
import type { FittedSurface } from "../../fit/distances/FittedSurface";
import { type FitSlice, isAtRest } from "../../fit/state";
import { bringNearer, ORDER } from "../../viewer/overlaid";
import type { Part, Viewer } from "../../viewer/Viewer";
import { type Asymmetry, asymmetryOf, mirroredBreast } from "./mirroredBreast";
import { MIRROR_MM } from "./MirrorLegend";

const OPACITY = 0.8;

type Shown = Pick<FitSlice, "fit" | "showMirror">;

/** Neutral within the scanner's noise, then as distances are coloured, stretched to the ends of this scale. */
function colourAt(mm: number): readonly [number, number, number] {
  if (Math.abs(mm) <= SCANNER_MM) return colourOf(0);
  return colourOf(Math.sign(mm) * (SCANNER_MM + ((Math.abs(mm) - SCANNER_MM) / (MIRROR_MM - SCANNER_MM)) * (SCALE_MM - SCANNER_MM)));
}

export class MirrorOverlay implements Part<Shown> {
  private mesh: Mesh<BufferGeometry, MeshLambertMaterial> | null = null;
  private of: BufferGeometry | null = null;
  private readonly material = new MeshLambertMaterial({ vertexColors: true, color: new Color(0xffffff), transparent: true, opacity: OPACITY, depthWrite: false });

  constructor(
    private readonly viewer: Viewer,
    private readonly fitted: FittedSurface,
    private readonly measured: (asymmetry: Asymmetry | null) => void,
  ) {
    viewer.beforeFrame.add(() => bringNearer([this.material], true, viewer.depthUnits));
  }

  update(state: Shown): void {
    const { fit } = state;
    const geometry = this.fitted.mesh?.geometry ?? null;
    const isWanted = state.showMirror && geometry !== null && fit?.result != null && isAtRest(fit);
    if (isWanted && geometry !== this.of) this.make(geometry, fit.result);
    if (this.mesh) this.mesh.visible = isWanted && geometry === this.of;
    if (!isWanted && geometry === null) this.of = null;
    this.viewer.invalidate();
  }

  private make(geometry: BufferGeometry, result: Parameters<typeof mirroredBreast>[1]): void {
    this.of = geometry;
    this.mesh?.removeFromParent();
    this.mesh?.geometry.dispose();
    this.mesh = null;
    const made = mirroredBreast(geometry, result);
    this.measured(made && asymmetryOf(made));
    if (!made) return;
    const colours = new Float32Array(4 * made.beyond.length); // the fourth is the opacity
    made.beyond.forEach((mm, vertex) => colours.set([...colourAt(mm), made.share[vertex]!], 4 * vertex));
    const shown = new BufferGeometry().setAttribute("position", new BufferAttribute(made.positions, 3)).setAttribute("color", new BufferAttribute(colours, 4));
    shown.setIndex(new BufferAttribute(made.index, 1));
    shown.computeVertexNormals();
    this.mesh = new Mesh(shown, this.material);
    this.mesh.name = "mirrored";
    this.mesh.renderOrder = ORDER.mirrored;
    this.mesh.raycast = () => undefined;
    this.viewer.body.add(this.mesh);
  }
}
