// Lines of constant width on the screen with a thin contrasting outline, lying on a surface.
// Neither line nor outline writes depth, and both are drawn towards the eye by a depth offset: no z-fighting.
import { Group } from "three";
import { LineMaterial } from "three/addons/lines/LineMaterial.js";
import { LineSegments2 } from "three/addons/lines/LineSegments2.js";
import { LineSegmentsGeometry } from "three/addons/lines/LineSegmentsGeometry.js";

export interface Polyline {
  /** x y z in a row, metres */
  points: Float32Array;
  isClosed: boolean;
  /** per point: the way on from here leads over a hole */
  bridged: readonly boolean[] | null;
}

const WIDTH = 3; // pixels
const OUTLINE = 1.2; // pixels on each side
const GUESSED = 0.7; // opacity where the scan shows no skin: dashed and paler, as a guess is
const TOWARDS_EYE = 0.012; // metres: over the noise of scan and fit, not through a limb

/** Start and end points of the segments that are bridged, or of those that are not. */
export function segments(lines: readonly Polyline[], wantBridged: boolean): Float32Array {
  const out: number[] = [];
  for (const { points, isClosed, bridged } of lines) {
    const count = points.length / 3;
    for (let i = 0; i < (isClosed ? count : count - 1); i += 1) {
      const next = (i + 1) % count;
      const isBridged = bridged !== null && (bridged[i]! || bridged[next]!);
      if (isBridged === wantBridged) out.push(...points.subarray(3 * i, 3 * i + 3), ...points.subarray(3 * next, 3 * next + 3));
    }
  }
  return new Float32Array(out);
}

function material(width: number, dashed: boolean): LineMaterial {
  const made = new LineMaterial({ linewidth: width, dashed, dashSize: 0.006, gapSize: 0.005, worldUnits: false });
  made.transparent = true; // drawn after the translucent model, so that its clay does not tint the line
  if (dashed) made.opacity = GUESSED;
  made.depthWrite = false;
  made.polygonOffset = true;
  return made;
}

export class FatLines {
  readonly group = new Group();
  private readonly inks: LineMaterial[] = [];
  private readonly outlines: LineMaterial[] = [];
  private readonly pairs = [false, true].map((dashed) => ({ dashed, outline: this.strand(dashed, true), ink: this.strand(dashed, false) }));

  private strand(dashed: boolean, isOutline: boolean): LineSegments2 {
    const made = material(isOutline ? WIDTH + 2 * OUTLINE : WIDTH, dashed);
    (isOutline ? this.outlines : this.inks).push(made);
    const strand = new LineSegments2(new LineSegmentsGeometry(), made);
    strand.renderOrder = isOutline ? 10 : 11;
    strand.frustumCulled = false;
    strand.visible = false;
    strand.raycast = () => undefined;
    this.group.add(strand);
    return strand;
  }

  paint(ink: { getHex(): number }, outline: { getHex(): number }): void {
    for (const each of this.inks) each.color.setHex(ink.getHex());
    for (const each of this.outlines) each.color.setHex(outline.getHex());
  }

  /** `unitsPerMetre`: depth units that a metre at the body's distance is worth. */
  approach(unitsPerMetre: number): void {
    for (const each of [...this.inks, ...this.outlines]) each.polygonOffsetUnits = -TOWARDS_EYE * unitsPerMetre;
  }

  set(lines: readonly Polyline[]): void {
    for (const { dashed, ink, outline } of this.pairs) {
      const points = segments(lines, dashed);
      for (const strand of [ink, outline]) {
        strand.visible = points.length > 0;
        if (points.length > 0) write(strand, points);
      }
    }
  }
}

/** Reuses the buffer while the number of segments stays, as it does from iteration to iteration. */
function write(strand: LineSegments2, points: Float32Array): void {
  const start = strand.geometry.attributes.instanceStart as { data?: { array: Float32Array; needsUpdate: boolean } } | undefined;
  if (start?.data?.array.length === points.length) {
    start.data.array.set(points);
    start.data.needsUpdate = true;
  } else {
    strand.geometry.dispose();
    strand.geometry = new LineSegmentsGeometry();
    strand.geometry.setPositions(points.slice());
  }
  if (strand.material.dashed) strand.computeLineDistances();
}
