// The lasso on the canvas: drawn with the first button, a pen or one finger; what it goes around is hidden when it is let go.
// Without a pointer: arrows move a cross, Enter sets a corner, and Enter at the same place again hides what lies within.
import { Matrix4 } from "three";
import type { PageSlice } from "../../store/page";
import type { Store } from "../../store/store";
import { svg } from "../../ui/dom";
import type { Crosshair } from "../../viewer/Crosshair";
import { ARROWS, onCanvasKey } from "../../viewer/keys";
import type { Viewer } from "../../viewer/Viewer";
import type { ScanActions } from "../actions";
import { type Crop, MOST, shareWithin } from "../crop";
import type { ScanMesh } from "../ScanMesh";
import type { ScanSlice } from "../state";
import * as text from "../text";

const STEP_PX = 3; // between corners: a hand's tremble is less
const LEAST_CORNERS = 6; // less is a click
const LEAST_SET = 3; // corners by keys
const CROSS_PX = 6; // as with the pen's cross
const ALL = 0.98; // of what is shown: nothing would be left to see

export function listenToLasso(canvas: HTMLElement, viewer: Viewer, scan: ScanMesh, cross: Crosshair, store: Store<ScanSlice & Pick<PageSlice, "announcement">>, actions: Pick<ScanActions, "crop" | "cropRefused">): void {
  let set: { x: number; y: number }[] = []; // corners by keys
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
    set = [];
    show([]);
  }

  function hide(corners: readonly { x: number; y: number }[], least: number): void {
    const geometry = scan.mesh?.geometry;
    if (!store.get().isCropping || corners.length < least || !geometry) return;
    const crop = cropOf(corners);
    const share = shareWithin(geometry.attributes.position!.array, geometry.index!.array, crop);
    if (share >= ALL) actions.cropRefused();
    else actions.crop(crop);
  }

  function setCorner({ x, y }: { readonly x: number; readonly y: number }): void {
    const last = set.at(-1);
    if (last && Math.hypot(x - last.x, y - last.y) < STEP_PX) {
      const corners = set;
      letGo();
      hide(corners, LEAST_SET);
      return;
    }
    set.push({ x, y });
    show(set);
    store.set({ announcement: text.crop.corner(set.length) });
  }

  /** True when the key meant something here. */
  function press(key: string, far: number): boolean {
    if (!store.get().isCropping) return false;
    const arrow = ARROWS[key];
    if (key === "Enter" && cross.place) setCorner(cross.place);
    else if (key === "Backspace" && set.length > 0) show(set = set.slice(0, -1));
    else if (!arrow) return false;
    else if (cross.isShown) cross.moveBy(far * CROSS_PX * arrow[0], far * CROSS_PX * arrow[1]);
    else {
      const box = viewer.host.getBoundingClientRect();
      cross.show(box.left + box.width / 2, box.top + box.height / 2);
    }
    return true;
  }
  onCanvasKey(canvas, press);

  function cropOf(corners: readonly { x: number; y: number }[]): Crop {
    viewer.scene.updateMatrixWorld();
    const { camera, body } = viewer;
    const toPicture = new Matrix4().multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse).multiply(body.matrixWorld).toArray();
    const lasso = corners.map(({ x, y }) => {
      const at = viewer.toCamera(x, y);
      return [at.x, at.y] as const;
    });
    const every = Math.ceil(lasso.length / MOST.corners); // of a very long line the service would not take all
    return { toPicture, lasso: lasso.filter((_, i) => i % every === 0) };
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
    hide(corners, LEAST_CORNERS);
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
      if (isCropping) return;
      letGo();
      cross.hide();
    },
  );
}
