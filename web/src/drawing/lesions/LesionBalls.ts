// Lesions inside the body, seen through the skin: a ball, and around it a pale one, how far it may reach nine times of ten.
// The one that is looked at has its shortest ways to the skin and to a line, and the skin turns to glass.
import { Matrix4, Mesh, MeshLambertMaterial, SphereGeometry, Vector3 } from "three";
import { mmFrom, metresFromMm } from "../../ui/units";
import type { PlanOnScan } from "../../api/types";
import { FatLines } from "../../viewer/lines/FatLines";
import type { Part, Viewer } from "../../viewer/Viewer";
import { type LaidLesion, lesionsOnScan, saidDistances } from "./lesions";

const COLOUR = "#b83280";
const STRENGTH = { ball: 0.9, other: 0.45, reach: 0.22 }; // opacity
const BALL = new SphereGeometry(1, 32, 16);

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
      return [ball(ballAt(at, each), chosen && chosen !== each ? STRENGTH.other : STRENGTH.ball), ...(each.error_mm ? [ball(reachAt(at, each), STRENGTH.reach)] : [])];
    });
    if (this.balls.length > 0) this.viewer.body.add(...this.balls);
    const ways = chosen ? saidDistances(chosen, line).filter(({ kind }) => kind !== "nipple") : [];
    this.ways.set(ways.map(({ point }) => ({ points: new Float32Array([...metres(chosen!.center), ...metres(point)]), isClosed: false, bridged: null, colour: COLOUR })));
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
function ball(matrix: Matrix4, opacity: number): Mesh {
  const made = new Mesh(BALL, new MeshLambertMaterial({ color: COLOUR, transparent: true, opacity, depthTest: false, depthWrite: false }));
  made.matrixAutoUpdate = false;
  made.matrix.copy(matrix);
  made.renderOrder = 10; // after the bands
  made.raycast = () => undefined;
  return made;
}
