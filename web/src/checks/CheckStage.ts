// The tour on the stage: the eye flies to the point, square to the skin; a disc shows where it may lie, a dot where it is by now; a
// click, a drag of the dot and the arrow keys move it.  Loaded when the first tour begins.
import { Raycaster, Vector3 } from "three";
import type { Vector } from "../api/types";
import { bandedDisc } from "../landmarks/LandmarkDiscs";
import type { RestingModel } from "../landmarks/ModelPicture";
import { sideOf } from "../landmarks/picks";
import type { LandmarksSlice } from "../landmarks/state";
import type { PageSlice } from "../store/page";
import { CLOSE_PIXELS } from "../landmarks/proposals/agreed";
import { only, type Store } from "../store/store";
import { button } from "../ui/controls";
import { el, setText } from "../ui/dom";
import { metresFromMm } from "../ui/units";
import { onClick } from "../viewer/clicks";
import { ARROWS } from "../viewer/keys";
import { Halo } from "../viewer/lines/Halo";
import { isHidden, pickAt, type Surface } from "../viewer/picking";
import type { Viewer } from "../viewer/Viewer";
import type { CheckActions } from "./actions";
import { ModelInset } from "./ModelInset";
import { type Check, type ChecksSlice, placeNow, stepNow, type TourStep } from "./state";
import * as text from "./text";

const DISC = 1.5; // half of the view, in radii of the disc, at least
const REACH = 24; // pixels from the dot's middle that still hold it
const FAR = 5; // times as far with Shift
const ABOVE = 0.004; // metres off the skin, from where the eye must be free to look
const UPRIGHT = 0.85; // sine of the steepest look: straight down has no upright
type Way = "below" | "side";

export function openCheckStage(store: Store<ChecksSlice & Pick<LandmarksSlice, "picks"> & Pick<PageSlice, "announcement">>, viewer: Viewer, scan: Surface & { readonly bvh: unknown; readonly isSettled: boolean }, torso: RestingModel, canvas: HTMLCanvasElement, actions: CheckActions): void {
  const halo = new Halo(viewer, "disc of the check", 8.6);
  const label = el("span", { class: "check-label" }, text.checks.disc);
  const dot = el("div", { class: "check-dot is-asked", hidden: true });
  const inset = new ModelInset(viewer, torso);
  const ways = (["below", "side"] as const).map((way) => ({ way, button: button(text.checks.ways[way], () => look(from === way ? null : way), "quiet") }));
  const bar = el("div", { class: "check-ways toolbar", role: "toolbar", "aria-label": text.checks.look, hidden: true }, ...ways.map((each) => each.button));
  let from: Way | null = null; // null: square to the skin
  viewer.overlay.append(dot, label);
  viewer.host.append(inset.element, bar);
  let before: Viewer["pose"] | null = null; // from where the tour began
  let seen: Check | null = null;
  let shown: TourStep | null = null;

  const point = (): Check | null => {
    const step = stepNow(store.get());
    return step?.kind === "point" ? step.check : null;
  };
  const place = (): Vector | null => {
    const { tour } = store.get().checks;
    return tour && placeNow(tour);
  };
  const metres = (at: Vector): Vector3 => new Vector3(...at.map(metresFromMm));

  /** Square to the skin, or as asked for; where that side is covered, as under a breast, from as near to it as the eye is free to look. */
  function outwards(place: Vector, normal: Vector): Vector3 {
    const square = new Vector3(...normal).transformDirection(viewer.body.matrixWorld);
    const at = viewer.body.localToWorld(metres(place));
    const side = { left: 1, right: -1, middle: Math.sign(square.x) || 1 }[sideOf(point()?.name ?? "")];
    const [ahead, aside, below] = [new Vector3(0, 0, 1), new Vector3(side, 0, 0.3).normalize(), new Vector3(0, -1, 0.6).normalize()] as const;
    const first = from === null ? square : { below, side: aside }[from];
    const ways = [first, ...[ahead, aside, below].map((way) => way.clone().add(first).normalize())].map((way) => way.clone().setY(Math.max(-UPRIGHT, Math.min(UPRIGHT, way.y))).normalize());
    const isFree = (way: Vector3): boolean => !scan.mesh || new Raycaster(at.clone().addScaledVector(square, ABOVE), way, 0, 0.4).intersectObject(scan.mesh, false).length === 0;
    return ways.find(isFree) ?? first;
  }

  function lookAt(place: Vector, normal: Vector, radiusMm: number): void {
    before ??= viewer.pose;
    viewer.scene.updateMatrixWorld();
    const half = Math.max(viewer.host.clientHeight / 2 / (1000 * CLOSE_PIXELS), DISC * metresFromMm(radiusMm));
    viewer.faceTo(place, outwards(place, normal), half);
  }

  /** The same point from below or from the side, which the front may hide; null: square to the skin. */
  function look(way: Way | null): void {
    from = way;
    for (const each of ways) each.button.setAttribute("aria-pressed", String(each.way === way));
    const check = point();
    if (check) lookAt(place() ?? check.place, check.normal, check.radius_mm);
  }

  let isLate = false; // the scan that is asked about is not on the stage yet, as when the panes have just changed over

  function update(): void {
    isLate = store.get().checks.tour !== null && !scan.isSettled;
    if (isLate) return viewer.invalidate();
    const check = point();
    if (check !== seen) {
      seen = check;
      const disc = check && bandedDisc({ point: check.place, mm: check.radius_mm }, scan, viewer);
      halo.set(disc ? [disc] : [], scan.mesh?.geometry ?? null);
      inset.show(check);
      dot.className = `check-dot is-asked side-${check ? sideOf(check.name) : "middle"}`;
      bar.hidden = check === null;
      look(null);
    }
    const step = stepNow(store.get());
    if (step !== shown) {
      shown = step;
      const picked = step?.kind === "question" && step.question.names.length === 1 ? store.get().picks.present[step.question.names[0]!] : undefined;
      if (picked) lookAt(picked, (scan.normalAt(metres(picked)) ?? new Vector3(0, 0, 1)).toArray(), 0);
    }
    if (!store.get().checks.tour && before) {
      viewer.travel(before);
      before = null;
    }
    dot.hidden = label.hidden = check === null;
    setText(label, text.checks.disc);
    viewer.invalidate();
  }

  viewer.beforeFrame.add(() => {
    if (isLate && scan.isSettled) update();
    if (inset.isOld) inset.show(seen);
    const at = place();
    if (!at || !seen) return;
    const where = metres(at);
    const { x, y } = viewer.toScreen(where);
    dot.style.transform = `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px)`;
    dot.classList.toggle("is-hidden", isHidden(viewer, scan, where, scan.normalAt(where)));
    const middle = viewer.toScreen(metres(seen.place));
    const radius = metresFromMm(seen.radius_mm) * viewer.pixelsPerMetre;
    label.style.transform = `translate(${Math.min(middle.x + radius + 12, viewer.host.clientWidth - label.offsetWidth - 8).toFixed(0)}px, ${(middle.y - 12).toFixed(0)}px)`;
  });

  /** To the skin under pixels of the page. */
  function moveTo(x: number, y: number): void {
    const hit = pickAt(viewer, scan, x, y);
    if (hit) actions.move(hit.point);
  }

  let held: number | null = null;
  canvas.addEventListener(
    "pointerdown",
    (event) => {
      const at = event.button === 0 && event.isPrimary ? place() : null;
      const on = at && viewer.toPage(at);
      if (!on || Math.hypot(on.x - event.clientX, on.y - event.clientY) > REACH) return;
      held = event.pointerId;
      viewer.mayTurn = false;
      canvas.setPointerCapture(event.pointerId);
    },
    { capture: true }, // before the view's own controls hear of it
  );
  canvas.addEventListener("pointermove", (event) => event.pointerId === held && moveTo(event.clientX, event.clientY));
  const letGo = (event: PointerEvent): void => {
    if (event.pointerId !== held) return;
    held = null;
    viewer.mayTurn = true;
  };
  canvas.addEventListener("pointerup", letGo);
  canvas.addEventListener("pointercancel", letGo);
  onClick(canvas, (event) => point() && moveTo(event.clientX, event.clientY));

  /** A millimetre along the skin, as the eye sees it. */
  function nudge(across: number, down: number): void {
    const at = place();
    if (!at) return;
    viewer.settle();
    const pixels = viewer.pixelsPerMetre / 1000;
    const on = viewer.toPage(at);
    const hit = pickAt(viewer, scan, on.x + across * pixels, on.y + down * pixels);
    if (hit) actions.move(hit.point);
    else store.set({ announcement: text.checks.noSkin });
  }

  addEventListener(
    "keydown",
    (event) => {
      if (!store.get().checks.tour || event.ctrlKey || event.metaKey || event.altKey || document.querySelector("dialog[open]")) return;
      const arrow = ARROWS[event.key];
      const far = event.shiftKey ? FAR : 1;
      const isOnAnswer = event.target instanceof HTMLElement && event.target.closest("button, a, summary, input, select") !== null;
      if (event.key === "Escape") actions.leave();
      else if (arrow && point()) nudge(far * arrow[0], far * arrow[1]);
      else if (event.key === "Enter" && point() && !isOnAnswer) actions.yes();
      else return;
      event.preventDefault();
      event.stopImmediatePropagation(); // neither the view nor the page's own keys hear of it
    },
    { capture: true },
  );

  store.select(only("checks"), update);
  update();
}
