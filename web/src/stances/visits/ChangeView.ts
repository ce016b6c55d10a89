// The map of a change on the body: turned by hand and keys, and what it says under the pointer.
import { Mesh, MeshStandardMaterial } from "three";
import type { Frame } from "../../api/types";
import { distanceWithin } from "../../fit/distances/distances";
import { el } from "../../ui/dom";
import { formatFixed, formatSignedMm } from "../../ui/units";
import { extent } from "../../viewer/extent";
import { disposeTree, firstMesh, readGltf } from "../../viewer/gltf";
import { listenToViewKeys } from "../../viewer/keys";
import { surfaceAt } from "../../viewer/picking";
import { PointerNote } from "../../viewer/PointerNote";
import { SideLetters } from "../../viewer/SideLetters";
import { Viewer, viewFromScan } from "../../viewer/Viewer";
import { visits as words } from "./text";
import "../../fit/distances/colour_bar.css";

/** Of a map: each vertex's change, null where nothing is said of it, and half the band; mm. */
interface Extras {
  readonly change_mm: readonly (number | null)[];
  readonly half_band_mm: number;
}

/** Fills `host` with the body of change.glb in the frame of its scan; the answer takes it out again.  Throws without WebGL 2. */
export async function openChange(host: HTMLElement, glb: ArrayBuffer, frame: Frame): Promise<() => void> {
  const gltf = await readGltf(glb);
  const mesh = firstMesh(gltf.scene)!;
  const { change_mm, half_band_mm: half } = (gltf.asset as { extras: Extras }).extras;
  const change = Float32Array.from(change_mm, (mm) => mm ?? NaN);
  const canvas = el("canvas", { class: "view", role: "img", "aria-label": words.body, tabindex: 0 });
  const overlay = el("div", { class: "overlay" });
  host.replaceChildren(canvas, overlay);
  const viewer = new Viewer(host, canvas, overlay, () => matchMedia("(prefers-reduced-motion: reduce)").matches);
  const skin = new Mesh(mesh.geometry, new MeshStandardMaterial({ vertexColors: true, roughness: 0.8, metalness: 0 }));
  viewer.body.add(skin);
  viewer.stand(frame, extent(mesh.geometry.attributes.position!.array, viewFromScan(frame)));
  viewer.lookFrom("front", false);
  listenToViewKeys(canvas, viewer, () => true);
  new SideLetters(viewer).update({ scan: skin });
  new PointerNote(viewer, canvas, "hover-value", true, (x, y) => {
    const hit = surfaceAt(viewer, skin, x, y);
    if (!hit) return null;
    const mm = distanceWithin(change, hit.corners, hit.weights);
    return mm === null ? ["", words.notCompared] : [words.here(formatSignedMm(mm)), Math.abs(mm) <= half ? words.within(formatFixed(half, 1)) : mm < 0 ? words.wentIn : words.cameOut];
  });
  return () => {
    disposeTree(gltf.scene);
    disposeTree(skin);
    viewer.renderer.dispose();
    viewer.renderer.forceContextLoss(); // browsers have few contexts, and take the oldest away
    host.replaceChildren();
  };
}
