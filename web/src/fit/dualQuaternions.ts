// The surface of a rig whose bones are blended by dual quaternions, posed here as the service poses it
// (server/breastrig/rig/skinning.py): graphics cards skin linearly.  A body is stretched first, at rest, and then moved.
import { BufferAttribute, BufferGeometry, type Material, Matrix4, Mesh, Quaternion, type SkinnedMesh, type TypedArray, Vector3 } from "three";

const MOTION = 8; // numbers of a dual quaternion, x y z w each: turn, then half of move times turn
const AFFINE = 12; // of an affine map, row by row

const numbers = (attribute: unknown): TypedArray => (attribute as BufferAttribute).array;

export class DualQuaternionSkin {
  /** The mesh's triangles with places and normals of the pose, in the mesh's own frame; metres. */
  readonly geometry = new BufferGeometry();
  private readonly surface = new BufferGeometry(); // the same without whatever triangles are added for looking
  private readonly motions: Float64Array;
  private readonly stretches: Float64Array;

  constructor(private readonly mesh: SkinnedMesh) {
    const { count } = mesh.geometry.attributes.position!;
    for (const each of [this.geometry, this.surface]) each.setIndex(mesh.geometry.index);
    for (const name of ["position", "normal"]) {
      const attribute = new BufferAttribute(new Float32Array(3 * count), 3);
      for (const each of [this.geometry, this.surface]) each.setAttribute(name, attribute);
    }
    this.motions = new Float64Array(MOTION * mesh.skeleton.bones.length);
    this.stretches = new Float64Array(AFFINE * mesh.skeleton.bones.length);
  }

  /** What shows the posed surface. */
  shown(material: Material | Material[]): Mesh {
    return new Mesh(this.geometry, material);
  }

  /** As SkinnedMesh has it. */
  getVertexPosition(vertex: number, target: Vector3): Vector3 {
    return target.fromBufferAttribute(this.geometry.attributes.position!, vertex);
  }

  /** By the world matrices, scales and weights of shapes as they are now. */
  pose(): void {
    this.readBones();
    const { geometry, morphTargetInfluences } = this.mesh;
    const places = Float64Array.from(numbers(geometry.attributes.position));
    morphTargetInfluences?.forEach((weight, shape) => {
      if (weight === 0) return;
      const moves = numbers(geometry.morphAttributes.position![shape]);
      for (let i = 0; i < places.length; i += 1) places[i]! += weight * moves[i]!;
    });
    const [bones, weights] = [numbers(geometry.attributes.skinIndex), numbers(geometry.attributes.skinWeight)];
    const posed = numbers(this.geometry.attributes.position);
    const motion = new Float64Array(MOTION);
    const stretch = new Float64Array(AFFINE);
    for (let vertex = 0; 3 * vertex < places.length; vertex += 1) {
      this.blend(bones, weights, 4 * vertex, motion, stretch);
      moved(places, 3 * vertex, motion, stretch, posed);
    }
    for (const name of ["position", "normal"]) this.geometry.attributes[name]!.needsUpdate = true;
    this.surface.computeVertexNormals();
  }

  private readBones(): void {
    const { bones, boneInverses } = this.mesh.skeleton;
    const toMesh = this.mesh.matrixWorld.clone().invert();
    bones.forEach((sized, bone) => {
      const toRest = boneInverses[bone]!;
      const [turn, move] = [new Quaternion(), new Vector3()];
      toMesh.clone().multiply(sized.parent!.matrixWorld).multiply(toRest).decompose(move, turn, new Vector3());
      const half = new Quaternion(move.x / 2, move.y / 2, move.z / 2, 0).multiply(turn);
      this.motions.set([...turn.toArray(), ...half.toArray()], MOTION * bone);
      const around = toRest.clone().invert().multiply(new Matrix4().makeScale(sized.scale.x, sized.scale.y, sized.scale.z)).multiply(toRest);
      this.stretches.set(around.transpose().elements.slice(0, AFFINE), AFFINE * bone);
    });
  }

  /** Of the four bones at `first`; their turns are taken on the side of the strongest one's. */
  private blend(bones: TypedArray, weights: TypedArray, first: number, motion: Float64Array, stretch: Float64Array): void {
    motion.fill(0);
    stretch.fill(0);
    let main = first;
    for (let i = first + 1; i < first + 4; i += 1) if (weights[i]! > weights[main]!) main = i;
    for (let i = first; i < first + 4; i += 1) {
      const [weight, bone] = [weights[i]!, bones[i]!];
      if (weight === 0) continue;
      let alike = 0;
      for (let k = 0; k < 4; k += 1) alike += this.motions[MOTION * bone + k]! * this.motions[MOTION * bones[main]! + k]!;
      const signed = alike < 0 ? -weight : weight;
      for (let k = 0; k < MOTION; k += 1) motion[k]! += signed * this.motions[MOTION * bone + k]!;
      for (let k = 0; k < AFFINE; k += 1) stretch[k]! += weight * this.stretches[AFFINE * bone + k]!;
    }
  }
}

/** Writes the place at `at`, stretched and moved, to the same place in `posed`. */
function moved(places: Float64Array, at: number, motion: Float64Array, stretch: Float64Array, posed: TypedArray): void {
  const [x, y, z] = [places[at]!, places[at + 1]!, places[at + 2]!];
  const row = (k: number): number => stretch[k]! * x + stretch[k + 1]! * y + stretch[k + 2]! * z + stretch[k + 3]!;
  const [a, b, c, w, e, f, g, h] = motion as unknown as [number, number, number, number, number, number, number, number];
  const square = a * a + b * b + c * c + w * w;
  const [p, q, r] = [row(0), row(4), row(8)];
  // twice the cross product of the turn's vector with the place, then what it does to it; and 2 e r* of the move
  const [u, v, t] = [2 * (b * r - c * q), 2 * (c * p - a * r), 2 * (a * q - b * p)];
  posed[at] = p + (w * u + b * t - c * v + 2 * (w * e - h * a + b * g - c * f)) / square;
  posed[at + 1] = q + (w * v + c * u - a * t + 2 * (w * f - h * b + c * e - a * g)) / square;
  posed[at + 2] = r + (w * t + a * v - b * u + 2 * (w * g - h * c + a * f - b * e)) / square;
}
