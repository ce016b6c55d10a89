// Moves the camera to a new place within 300 ms, round the body and not through it; a touch of the view ends it.
import { type PerspectiveCamera, Spherical, type Vector3 } from "three";
import type { OrbitControls } from "three/addons/controls/OrbitControls.js";

const LASTS_MS = 300;
const easeOut = (t: number): number => 1 - (1 - t) ** 3;

interface Journey {
  begins: number | null;
  from: Spherical;
  to: Spherical;
  fromTarget: Vector3;
  toTarget: Vector3;
}

export class CameraMove {
  private journey: Journey | null = null;

  constructor(
    private readonly camera: PerspectiveCamera,
    private readonly controls: OrbitControls,
    private readonly invalidate: () => void,
    private readonly prefersStill: () => boolean,
  ) {
    controls.addEventListener("start", () => (this.journey = null));
  }

  to(offset: Vector3, target: Vector3, isMoving: boolean): void {
    const now = this.camera.position.clone().sub(this.controls.target);
    const to = new Spherical().setFromVector3(offset);
    const from = now.lengthSq() > 0 ? new Spherical().setFromVector3(now) : to.clone();
    to.theta = from.theta + Math.atan2(Math.sin(to.theta - from.theta), Math.cos(to.theta - from.theta)); // shorter way
    this.journey = { begins: null, from, to, fromTarget: this.controls.target.clone(), toTarget: target };
    if (!isMoving || this.prefersStill()) this.place(this.journey, 1);
    this.invalidate();
  }

  /** At its goal at once. */
  finish(): void {
    if (this.journey) this.place(this.journey, 1);
  }

  advance(now: number): void {
    const journey = this.journey;
    if (!journey) return;
    journey.begins ??= now;
    this.place(journey, easeOut(Math.min(1, (now - journey.begins) / LASTS_MS)));
    if (this.journey) this.invalidate();
  }

  private place(journey: Journey, share: number): void {
    const { from, to } = journey;
    const mix = (a: number, b: number): number => a + (b - a) * share;
    const at = new Spherical(mix(from.radius, to.radius), mix(from.phi, to.phi), mix(from.theta, to.theta));
    this.controls.target.lerpVectors(journey.fromTarget, journey.toTarget, share);
    this.camera.position.setFromSpherical(at).add(this.controls.target);
    if (share >= 1) this.journey = null;
    this.controls.update();
  }
}
