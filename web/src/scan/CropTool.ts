// The lasso on the canvas: drawn with the first button, a pen or one finger; what it goes around is hidden when it is let go.
import { Matrix4 } from "three";
import type { Store } from "../store/store";
import { svg } from "../ui/dom";
import type { Viewer } from "../viewer/Viewer";
import type { ScanActions } from "./actions";
import { type Crop, shareWithin } from "./crop";
import type { ScanMesh } from "./ScanMesh";
import type { ScanSlice } from "./state";

const STEP_PX = 3; // between corners: a hand's tremble is less
const LEAST_CORNERS = 6; // less is a click
const ALL = 0.98; // of what is shown: nothing would be left to see

export function listenToLasso(canvas: HTMLElement, viewer: Viewer, scan: ScanMesh, store: Store<ScanSlice>, actions: Pick<ScanActions, "crop" | "cropRefused">): void {
  let held: { readonly id: number; readonly corners: { x: number; y: number }[] } | null = null;
  const pointers = new Set<number>();
  const line = svg("polygon", { points: "" });
  const picture = svg("svg", { class: "lasso" }, line);
  viewer.overlay.append(picture);

  function show(corners: readonly { x: number; y: number }[]): void {
    const box = viewer.host.getBoundingClientRect();
    line.setAttribute("points", corners.map(({ x, y }) => `${(x - box.left).toFixed(1)},${(y - box.top).toFixed(1)}`).join(" "));
  }

  function letGo(): void {
    held = null;
    show([]);
  }

  function cropOf(corners: readonly { x: number; y: number }[]): Crop {
    viewer.scene.updateMatrixWorld();
    const { camera, body } = viewer;
    const toPicture = new Matrix4().multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse).multiply(body.matrixWorld).toArray();
    const lasso = corners.flatMap(({ x, y }) => {
      const at = viewer.toCamera(x, y, "scan");
      return at ? [[at.x, at.y] as const] : [];
    });
    return { toPicture, lasso };
  }

  canvas.addEventListener("pointerdown", (event) => {
    pointers.add(event.pointerId);
    if (pointers.size > 1) letGo(); // two fingers turn
    if (pointers.size > 1 || !store.get().isCropping || event.button !== 0) return;
    held = { id: event.pointerId, corners: [{ x: event.clientX, y: event.clientY }] };
    canvas.setPointerCapture(event.pointerId);
  });
  canvas.addEventListener("pointermove", (event) => {
    if (event.pointerId !== held?.id) return;
    const last = held.corners.at(-1)!;
    if (Math.hypot(event.clientX - last.x, event.clientY - last.y) < STEP_PX) return;
    held.corners.push({ x: event.clientX, y: event.clientY });
    show(held.corners);
  });
  canvas.addEventListener("pointerup", (event) => {
    pointers.delete(event.pointerId);
    if (event.pointerId !== held?.id) return;
    const { corners } = held;
    letGo();
    const geometry = scan.mesh?.geometry;
    if (!store.get().isCropping || corners.length < LEAST_CORNERS || !geometry) return;
    const crop = cropOf(corners);
    const share = shareWithin(geometry.attributes.position!.array, geometry.index!.array, crop);
    if (share >= ALL) actions.cropRefused();
    else actions.crop(crop);
  });
  canvas.addEventListener("pointercancel", (event) => {
    pointers.delete(event.pointerId);
    if (event.pointerId === held?.id) letGo();
  });
  store.select(
    ({ isCropping }) => ({ isCropping }),
    ({ isCropping }) => {
      viewer.drawWith(isCropping ? "anything" : "nothing");
      canvas.classList.toggle("is-cropping", isCropping);
      if (!isCropping) letGo();
    },
  );
}
