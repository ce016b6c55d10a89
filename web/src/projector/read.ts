// What the second screen needs of a fit: the plan's lines as the service lays them on the scan, landmarks, and the surfaces
// that decide what is seen.
import type { BufferGeometry } from "three";
import { MeshBVH } from "three-mesh-bvh";
import type { Client } from "../api/client";
import type { Fit, Frame, Vector } from "../api/types";
import { isUnit, metresFromMm, mmFrom, unknownUnit } from "../ui/units";
import { firstMesh, readGltf } from "../viewer/gltf";
import { tidyFrame } from "../viewer/frame";
import { geometryOf, readPly } from "../viewer/ply";
import type { Bodies } from "./Picture";
import { type Landmark, ORDER, type PlannedLine } from "./state";

export interface Opened {
  readonly fit: Fit;
  readonly planLink: string; // of the patient's plan, whose version says whether to read again
  readonly landmarks: readonly Landmark[];
  readonly frame: Frame;
  readonly bodies: Bodies;
}

type Asked = Pick<Client, "fit" | "scan" | "mesh" | "result" | "bytes" | "meta" | "planOnFit" | "drawing">;

function withTree(geometry: BufferGeometry): BufferGeometry {
  if (!geometry.index) geometry.setIndex([...Array(geometry.attributes.position!.count).keys()]);
  geometry.boundsTree = new MeshBVH(geometry, { indirect: true });
  return geometry;
}

export async function openFit(client: Asked, id: string): Promise<Opened> {
  const fit = await client.fit(id);
  const [scan, result, ply] = await Promise.all([client.scan(fit.scan), client.result(fit.links.result), client.bytes(fit.links.fitted_ply).then(readPly)]);
  const meta = await client.meta(scan.model);
  const { scene } = await readGltf(await client.mesh(scan));
  scene.updateMatrixWorld(true);
  const mesh = firstMesh(scene);
  if (!mesh) throw new Error("the scan has no mesh");
  const { unit } = result.scan;
  if (!isUnit(unit)) throw new Error(unknownUnit(unit));
  const perUnit = mmFrom(1, unit);
  const model = geometryOf(ply, metresFromMm(perUnit));
  const labels = new Map(meta.landmarks.map(({ name, label }) => [name, label]));
  const rank = (name: string): number => (ORDER.includes(name) ? ORDER.indexOf(name) : ORDER.length);
  const landmarks = Object.entries(result.landmarks)
    .map(([name, point]): Landmark => ({ name, label: labels.get(name) ?? name, point: point.map((value) => value * perUnit) as Vector }))
    .sort((a, b) => rank(a.name) - rank(b.name));
  const bodies = { skin: withTree(mesh.geometry.applyMatrix4(mesh.matrixWorld)), model: withTree(model) };
  return { fit, planLink: scan.links.plan, landmarks, frame: tidyFrame(scan.frame), bodies };
}

/** All that is planned, whether it was made here or carried; until somebody writes the plan, the fit's own drawing. */
export async function readLines(client: Asked, fit: Fit): Promise<PlannedLine[]> {
  const plan = await client.planOnFit(fit.links.plan);
  const own = plan.whole || fit.drawing === null ? null : await client.drawing(fit.links.drawing);
  const inMm = (shape: Partial<Pick<PlannedLine, "closed" | "color">> & { readonly name: string; readonly bridged?: readonly boolean[] | null; readonly points: readonly Vector[] }, unit: Parameters<typeof mmFrom>[1]): PlannedLine => ({
    name: shape.name,
    closed: shape.closed ?? false,
    color: shape.color ?? "#ffffff",
    bridged: [...(shape.bridged ?? [])],
    points: shape.points.map((point) => point.map((value) => mmFrom(value, unit)) as Vector),
  });
  return [...plan.shapes.map((shape) => inMm(shape, plan.unit)), ...(own?.shapes ?? []).map((shape) => inMm(shape, own!.unit))];
}
