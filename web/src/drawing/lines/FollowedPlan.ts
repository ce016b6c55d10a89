// While a landmark is dragged the plan goes with the model: each of its points by as much as the model's skin next to it, and back
// onto the scan.  The fit that is made afterwards lays it anew.
import { Triangle, Vector3 } from "three";
import type { FittedSurface } from "../../fit/distances/FittedSurface";
import { type FitSlice, isAtRest, isFollowing } from "../../fit/state";
import type { TorsoModel } from "../../fit/TorsoModel";
import type { ScanMesh } from "../../scan/ScanMesh";
import { isUnit, metresFromMm, mmFrom } from "../../ui/units";
import type { DrawingSlice, DrawnState, Laid, OnScan } from "../state";

type State = Pick<FitSlice, "fit" | "followed"> & Pick<DrawingSlice, "drawn">;

/** Where on the model a point of the plan lies: corners and their shares. */
interface Place {
  readonly corners: readonly [number, number, number];
  readonly shares: Vector3;
}

export class FollowedPlan {
  private rest: { readonly fit: string; readonly vertices: Float32Array } | null = null; // of the fit's own pose
  private places: { readonly of: OnScan; readonly known: Map<string, Place | null> } | null = null;
  private made: { readonly of: OnScan; readonly followed: object; readonly moved: OnScan } | null = null;

  constructor(
    private readonly torso: Pick<TorsoModel, "mesh" | "vertexAt">,
    private readonly fitted: Pick<FittedSurface, "mesh" | "bvh">,
    private readonly scan: Pick<ScanMesh, "bvh">,
  ) {}

  /** What is drawn, as it goes with the model; the same where nothing is followed.  Called after the model has been posed. */
  drawn(state: State): DrawnState {
    const { fit, followed, drawn } = state;
    if (!isFollowing(state)) {
      this.remember(state);
      return drawn;
    }
    const { onScan } = drawn;
    if (!onScan || !followed || this.rest?.fit !== fit?.id || !this.scan.bvh || !this.fitted.bvh || !this.torso.vertexAt) return drawn;
    if (this.made?.of !== onScan || this.made.followed !== followed) this.made = { of: onScan, followed, moved: { ...onScan, patterns: this.moved(onScan, onScan.patterns), carried: this.moved(onScan, onScan.carried) } };
    return { ...drawn, onScan: this.made.moved };
  }

  private remember({ fit }: State): void {
    const { mesh, vertexAt } = this.torso;
    if (!fit || !isAtRest(fit) || !mesh || !vertexAt || this.rest?.fit === fit.id) return;
    const vertices = new Float32Array(3 * mesh.geometry.attributes.position!.count);
    const at = new Vector3();
    for (let i = 0; i < vertices.length / 3; i += 1) vertexAt(i, at).toArray(vertices, 3 * i);
    this.rest = { fit: fit.id, vertices };
  }

  private moved(onScan: OnScan, laid: Laid): Laid {
    if (!isUnit(laid.unit)) return laid;
    const perUnit = metresFromMm(mmFrom(1, laid.unit));
    if (this.places?.of !== onScan) this.places = { of: onScan, known: new Map() };
    const { known } = this.places;
    const vertexAt = this.torso.vertexAt!;
    const [at, corner, rest] = [new Vector3(), new Vector3(), new Vector3()];
    const pointTo = (point: readonly number[]): [number, number, number] => {
      at.fromArray(point).multiplyScalar(perUnit);
      const key = point.join();
      let place = known.get(key);
      if (place === undefined) known.set(key, (place = this.placeOf(at)));
      if (!place) return [...point] as [number, number, number];
      place.corners.forEach((vertex, k) => at.addScaledVector(vertexAt(vertex, corner).sub(rest.fromArray(this.rest!.vertices, 3 * vertex)), place.shares.getComponent(k)));
      return (this.scan.bvh!.closestPointToPoint(at)?.point ?? at).clone().divideScalar(perUnit).toArray();
    };
    return { ...laid, shapes: laid.shapes.map((shape) => ({ ...shape, points: shape.points.map(pointTo) })) };
  }

  /** On the fitted surface, whose triangles are those of the rig; null on a lid that closes it. */
  private placeOf(at: Vector3): Place | null {
    const hit = this.fitted.bvh!.closestPointToPoint(at);
    const index = this.torso.mesh!.geometry.index!;
    if (!hit || 3 * hit.faceIndex + 2 >= index.count) return null;
    const { index: own, attributes } = this.fitted.mesh!.geometry;
    const [a, b, c] = [0, 1, 2].map((k) => new Vector3().fromBufferAttribute(attributes.position!, own!.getX(3 * hit.faceIndex + k)));
    const shares = Triangle.getBarycoord(hit.point, a!, b!, c!, new Vector3());
    return shares && { corners: [index.getX(3 * hit.faceIndex), index.getX(3 * hit.faceIndex + 1), index.getX(3 * hit.faceIndex + 2)], shares };
  }
}
