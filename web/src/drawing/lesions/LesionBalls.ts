// Lesions inside the body, seen through the skin: a ball, and around it a pale one that holds its true centre with 90 %.
import { Mesh, MeshBasicMaterial, SphereGeometry } from "three";
import { mmFrom, metresFromMm } from "../../ui/units";
import type { Part, Viewer } from "../../viewer/Viewer";
import type { DrawingSlice, OnScan } from "../state";
import { lesionsOnScan } from "./lesions";

const COLOUR = "#b83280";
const STRENGTH = { ball: 0.85, error: 0.16 }; // opacity
const BALL = new SphereGeometry(1, 32, 16);

export class LesionBalls implements Part<Pick<DrawingSlice, "drawn">> {
  private shown: OnScan | null = null;
  private balls: Mesh[] = [];

  constructor(private readonly viewer: Viewer) {}

  update({ drawn }: Pick<DrawingSlice, "drawn">): void {
    if (drawn.onScan === this.shown) return;
    this.shown = drawn.onScan;
    for (const ball of this.balls) ball.removeFromParent();
    const mmPerUnit = mmFrom(1, drawn.onScan?.plan.unit ?? "mm");
    this.balls = lesionsOnScan(drawn.onScan?.plan ?? null).flatMap(({ center, radius_mm, error_mm }) => {
      const place = center.map((value) => metresFromMm(value * mmPerUnit)) as [number, number, number];
      return [ball(place, metresFromMm(radius_mm), STRENGTH.ball), ...(error_mm ? [ball(place, metresFromMm(error_mm), STRENGTH.error)] : [])];
    });
    if (this.balls.length > 0) this.viewer.body.add(...this.balls);
    this.viewer.invalidate();
  }
}

/** Drawn over the skin: what is inside would not be seen otherwise. */
function ball(place: [number, number, number], radius: number, opacity: number): Mesh {
  const made = new Mesh(BALL, new MeshBasicMaterial({ color: COLOUR, transparent: true, opacity, depthTest: false, depthWrite: false }));
  made.position.set(...place);
  made.scale.setScalar(radius);
  made.renderOrder = 10; // after the bands
  made.raycast = () => undefined;
  return made;
}
