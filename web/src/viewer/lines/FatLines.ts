// Lines of constant width on the screen with a thin contrasting outline, lying on a surface.
// Neither line nor outline writes depth, and both are drawn towards the eye by a depth offset: no z-fighting.
import { type BufferGeometry, Color, Group, Mesh, Vector4 } from "three";
import { LineMaterial } from "three/addons/lines/LineMaterial.js";
import { LineTriangles } from "./lineTriangles";

export interface Polyline {
  /** x y z in a row, metres */
  points: Float32Array;
  isClosed: boolean;
  /** per point: the way on from here leads over a hole */
  bridged: readonly boolean[] | null;
  /** #rrggbb, as the drawing's file has it; without it the ink that all are painted with */
  colour?: string | null;
}

const WIDTH = 3; // pixels
const OUTLINE = 1.2; // pixels on each side
const GUESSED = 0.7; // opacity where the scan shows no skin: dashed and paler, as a guess is
const TOWARDS_EYE = 0.012; // metres: over the noise of scan and fit, not through a limb

/** All of it as a guess: of a body that no scan shows. */
export const allGuessed = (line: Polyline): Polyline => ({ ...line, bridged: Array.from({ length: line.points.length / 3 }, () => true) });

/** From which point of which line to which the segments lead that are bridged, or those that are not. */
function* steps(lines: readonly Polyline[], wantBridged: boolean): Generator<readonly [line: Polyline, from: number, to: number]> {
  for (const line of lines) {
    const { points, isClosed, bridged } = line;
    const count = points.length / 3;
    for (let i = 0; i < (isClosed ? count : count - 1); i += 1) {
      const next = (i + 1) % count;
      const isBridged = bridged !== null && (bridged[i]! || bridged[next]!);
      if (isBridged === wantBridged) yield [line, i, next];
    }
  }
}

/** Start and end points of the segments that are bridged, or of those that are not. */
export function segments(lines: readonly Polyline[], wantBridged: boolean): Float32Array {
  const out: number[] = [];
  for (const [{ points }, from, to] of steps(lines, wantBridged)) out.push(...points.subarray(3 * from, 3 * from + 3), ...points.subarray(3 * to, 3 * to + 3));
  return new Float32Array(out);
}

/** What lines are drawn with that bring no colour, and what a bright or a dark line is outlined with. */
export interface Ink {
  readonly ink: Color;
  readonly outline: Color;
}

const BRIGHT = 0.35; // luminance from which a line needs a dark outline
const DARK_OUTLINE = new Color("#1c1c1e");
const BRIGHT_OUTLINE = new Color("#ffffff");

/** A line's own colour with the outline that contrasts with it; without one, what all are painted with. */
export function inkOf(colour: string | null | undefined, paint: Ink): Ink {
  if (colour == null) return paint;
  const ink = new Color(colour); // linear from here on
  const luminance = 0.2126 * ink.r + 0.7152 * ink.g + 0.0722 * ink.b;
  return { ink, outline: luminance > BRIGHT ? DARK_OUTLINE : BRIGHT_OUTLINE };
}

/** Linear red, green and blue at both ends of each of these segments. */
export function segmentColours(lines: readonly Polyline[], wantBridged: boolean, paint: Ink, part: keyof Ink): Float32Array {
  const out: number[] = [];
  const known = new Map<Polyline, Color>();
  for (const [line] of steps(lines, wantBridged)) {
    let colour = known.get(line);
    if (!colour) known.set(line, (colour = inkOf(line.colour, paint)[part]));
    out.push(colour.r, colour.g, colour.b, colour.r, colour.g, colour.b);
  }
  return new Float32Array(out);
}

function material(width: number, dashed: boolean, isOver: boolean): LineMaterial {
  const made = new LineMaterial({ linewidth: width, dashed, dashSize: 0.006, gapSize: 0.005, worldUnits: false, vertexColors: true });
  made.transparent = true; // drawn after the translucent model, so that its clay does not tint the line
  if (dashed) made.opacity = GUESSED;
  made.depthWrite = false;
  made.depthTest = !isOver;
  made.polygonOffset = true;
  return made;
}

/** One surface of segments in one colouring. */
function strandOf(geometry: BufferGeometry, made: LineMaterial, isOutline: boolean): Mesh {
  const strand = new Mesh(geometry, made);
  const viewport = new Vector4();
  strand.onBeforeRender = (renderer) => {
    renderer.getViewport(viewport);
    made.resolution.set(viewport.z, viewport.w); // widths are counted in its pixels
  };
  strand.renderOrder = isOutline ? 10 : 11;
  strand.frustumCulled = false;
  strand.visible = false;
  strand.raycast = () => undefined;
  return strand;
}

interface Pair {
  readonly dashed: boolean;
  readonly triangles: LineTriangles<keyof Ink>;
  readonly strands: readonly Mesh[];
}

export class FatLines {
  readonly group = new Group();
  private readonly materials: LineMaterial[] = [];
  private lines: readonly Polyline[] = [];
  private painted: Ink = { ink: new Color(), outline: new Color() };
  private readonly pairs: readonly Pair[];

  /** `isOver`: seen through everything. */
  constructor(isOver = false) {
    this.pairs = [false, true].map((dashed) => {
      const triangles = new LineTriangles<keyof Ink>(["outline", "ink"], dashed);
      const strands = (["outline", "ink"] as const).map((part) => {
        const made = material(part === "outline" ? WIDTH + 2 * OUTLINE : WIDTH, dashed, isOver);
        this.materials.push(made);
        return strandOf(triangles.geometries[part], made, part === "outline");
      });
      this.group.add(...strands);
      return { dashed, triangles, strands };
    });
  }

  /** The colours of lines that bring none. */
  paint(ink: Color, outline: Color): void {
    if (this.painted.ink.equals(ink) && this.painted.outline.equals(outline)) return;
    this.painted = { ink: ink.clone(), outline: outline.clone() };
    this.set(this.lines);
  }

  /** `unitsPerMetre`: depth units that a metre at the body's distance is worth. */
  approach(unitsPerMetre: number): void {
    for (const each of this.materials) each.polygonOffsetUnits = -TOWARDS_EYE * unitsPerMetre;
  }

  set(lines: readonly Polyline[]): void {
    this.lines = lines;
    for (const { dashed, triangles, strands } of this.pairs) {
      const points = segments(lines, dashed);
      for (const strand of strands) strand.visible = points.length > 0;
      if (points.length === 0) continue;
      const colours = (part: keyof Ink): Float32Array => segmentColours(lines, dashed, this.painted, part);
      triangles.set(points, { ink: colours("ink"), outline: colours("outline") });
    }
  }
}
