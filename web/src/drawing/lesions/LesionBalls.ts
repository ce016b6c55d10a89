// Lesions inside the body, seen through the skin: a ball with a dark rim, and around it a pale one with a dashed rim, how far it
// may reach nine times of ten.  The one that is looked at has its shortest ways to the skin and to a line, and the skin turns to glass.
import { type Color, type Material, Matrix4, Mesh, MeshBasicMaterial, MeshLambertMaterial, SphereGeometry, Vector3 } from "three";
import { mmFrom, metresFromMm } from "../../ui/units";
import type { PlanOnScan } from "../../api/types";
import { FatLines } from "../../viewer/lines/FatLines";
import type { Part, Viewer } from "../../viewer/Viewer";
import { type LaidLesion, lesionsOnScan, saidDistances } from "./lesions";

const STRENGTH = { ball: 0.95, other: 0.45, reach: 0.3 }; // opacity
const BALL = new SphereGeometry(1, 48, 24);
const RIM_PIXELS = 1.6;
const DASHES = 30; // around a reach

interface Shown {
  readonly plan: PlanOnScan | null;
  readonly lesion: string | null; // id of the one that is looked at
  readonly line: string | null; // the chosen one
}

export class LesionBalls implements Part<Shown> {
  private shown: Shown = { plan: null, lesion: null, line: null };
  private balls: Mesh[] = [];
  private readonly ways = new FatLines(true);

  constructor(private readonly viewer: Viewer) {
    viewer.body.add(this.ways.group);
  }

  update(state: Shown): void {
    this.ways.paint(this.viewer.palette.ink, this.viewer.palette["ink-outline"]);
    const { plan, lesion, line } = state;
    const { shown } = this;
    if (plan === shown.plan && lesion === shown.lesion && line === shown.line) return;
    this.shown = { plan, lesion, line };
    for (const ball of this.balls) ball.removeFromParent();
    const metres = (place: readonly number[]): Vector3 => new Vector3(...place).multiplyScalar(metresFromMm(mmFrom(1, plan?.unit ?? "mm")));
    const lesions = lesionsOnScan(plan);
    const chosen = lesions.find(({ id }) => id === lesion);
    this.viewer.isGlass = chosen !== undefined;
    this.balls = lesions.flatMap((each) => {
      const at = metres(each.center);
      const { lesion: colour } = this.viewer.palette;
      const reach = each.error_mm ? [ball(reachAt(at, each), colour, STRENGTH.reach, true)] : [];
      return [...reach, ball(ballAt(at, each), colour, chosen && chosen !== each ? STRENGTH.other : STRENGTH.ball, false)];
    });
    if (this.balls.length > 0) this.viewer.body.add(...this.balls);
    const ways = chosen ? saidDistances(chosen, line).filter(({ kind }) => kind !== "nipple") : [];
    this.ways.set(ways.map(({ point }) => ({ points: new Float32Array([...metres(chosen!.center), ...metres(point)]), isClosed: false, bridged: null, colour: `#${this.viewer.palette.lesion.getHexString()}` })));
    this.viewer.invalidate();
  }
}

const ballAt = (at: Vector3, { radius_mm }: LaidLesion): Matrix4 => new Matrix4().makeScale(...ofSize(radius_mm)).setPosition(at);

/** The ellipsoid of its centre, larger by its radius. */
function reachAt(at: Vector3, { radius_mm, error_mm, ellipsoid_mm }: LaidLesion): Matrix4 {
  if (!ellipsoid_mm) return new Matrix4().makeScale(...ofSize(radius_mm + (error_mm ?? 0))).setPosition(at);
  const [a, b, c] = ellipsoid_mm.map((axis) => {
    const made = new Vector3(...axis);
    return made.setLength(metresFromMm(made.length() + radius_mm));
  });
  return new Matrix4().makeBasis(a!, b!, c!).setPosition(at);
}

const ofSize = (mm: number): [number, number, number] => [metresFromMm(mm), metresFromMm(mm), metresFromMm(mm)];

/** Drawn over the skin: what is inside would not be seen otherwise. */
function ball(matrix: Matrix4, color: Color, opacity: number, isReach: boolean): Mesh {
  const made = new Mesh(BALL, isReach ? reachMaterial(color, opacity) : ballMaterial(color, opacity));
  made.matrixAutoUpdate = false;
  made.matrix.copy(matrix);
  made.renderOrder = isReach ? 9.5 : 10; // after the bands
  made.raycast = () => undefined;
  return made;
}

const ballMaterial = (color: Color, opacity: number): Material => rimmed(new MeshLambertMaterial({ color, transparent: true, opacity, depthTest: false, depthWrite: false }), "1.0");

/** Even, for it is no thing that a light falls on. */
const reachMaterial = (color: Color, opacity: number): Material =>
  rimmed(new MeshBasicMaterial({ color, transparent: true, opacity, depthTest: false, depthWrite: false }), `step(0.4, fract(atan(vOut.y, vOut.x) * ${(DASHES / (2 * Math.PI)).toFixed(4)}))`);

/** With a dark line of constant width where the eye sees the surface from the side, as far as `dashes` is 1. */
function rimmed(made: MeshBasicMaterial | MeshLambertMaterial, dashes: string): Material {
  made.onBeforeCompile = (shader) => {
    shader.vertexShader = shader.vertexShader
      .replace("#include <common>", "#include <common>\nvarying vec3 vOut;\nvarying vec3 vSeen;")
      .replace("#include <project_vertex>", "#include <project_vertex>\nvOut = normalize(normalMatrix * normal);\nvSeen = -mvPosition.xyz;");
    shader.fragmentShader = shader.fragmentShader
      .replace("#include <common>", "#include <common>\nvarying vec3 vOut;\nvarying vec3 vSeen;")
      .replace(
        "#include <opaque_fragment>",
        `#include <opaque_fragment>
        float turned = dot(normalize(vOut), normalize(vSeen));
        float rim = 1.0 - smoothstep(${RIM_PIXELS.toFixed(1)}, ${(RIM_PIXELS + 1).toFixed(1)}, turned * turned / fwidth(turned * turned));
        gl_FragColor = mix(gl_FragColor, vec4(vec3(0.005), 0.95), rim * ${dashes});`,
      );
  };
  made.customProgramCacheKey = () => `rim ${dashes}`;
  return made;
}
