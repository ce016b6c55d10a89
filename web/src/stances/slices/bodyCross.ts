// The slices' cross on the body beside them: two lines through its place, seen through the skin; a click on the skin puts it
// there, two enlarge the body.
import { Vector3 } from "three";
import type { Vector } from "../../api/types";
import type { SlicesState } from "../../drawing/slices/state";
import { only, type Store } from "../../store/store";
import { el } from "../../ui/dom";
import { metresFromMm } from "../../ui/units";
import { onClick } from "../../viewer/clicks";
import { pickAt, type Surface } from "../../viewer/picking";
import type { Viewer } from "../../viewer/Viewer";
import { bodyBeside, crossOnBody, isSliced, slicedOf, type SlicesShown } from "./shown";

interface Body {
  readonly viewer: Viewer;
  readonly canvas: HTMLCanvasElement;
  readonly surface: Surface | null; // where a click can put the cross
}

/** `other`: of the second pane, once it is made. */
export function followSlices<State extends SlicesShown>(store: Store<State>, change: (slices: Partial<SlicesState>) => void, bodies: Readonly<Record<"main" | "other", () => Body | null>>): void {
  const dressed = new Map<"main" | "other", Viewer>();

  function dress(name: "main" | "other", { viewer, canvas, surface }: Body): void {
    const lines = (["is-flat", "is-steep"] as const).map((look) => el("div", { class: `body-cross ${look}`, hidden: true }));
    viewer.overlay.append(...lines);
    viewer.beforeFrame.add(() => {
      const place = crossOnBody(store.get(), name);
      for (const line of lines) line.hidden = place === null;
      if (!place) return;
      const { x, y } = viewer.toScreen(new Vector3(...place.map(metresFromMm)));
      lines[0]!.style.transform = `translateY(${y.toFixed(1)}px)`;
      lines[1]!.style.transform = `translateX(${x.toFixed(1)}px)`;
    });
    onClick(canvas, ({ clientX, clientY }) => {
      const state = store.get();
      const { of, isMain } = slicedOf(state);
      if (!isSliced(state) || state.drawn.tool !== "none" || isMain !== (name === "main") || !surface || !of.scan) return;
      const hit = pickAt(viewer, surface, clientX, clientY);
      if (hit) change({ cross: { scan: of.scan.info.id, at: hit.point.map((value) => Math.round(10 * value) / 10) as unknown as Vector }, moves: false });
    });
    canvas.addEventListener("dblclick", () => {
      const state = store.get();
      if (isSliced(state) && bodyBeside(state) === name && state.drawn.tool === "none") change({ enlarged: state.slices.enlarged === "body" ? null : "body" });
    });
  }

  store.select(only("step", "scan", "active", "isCropping", "isCanvasFull", "drawn", "lesion", "slices", "stances", "checks"), () => {
    for (const name of ["main", "other"] as const) {
      const body = bodies[name]();
      if (body && dressed.get(name) !== body.viewer) {
        dressed.set(name, body.viewer);
        dress(name, body);
      }
      body?.viewer.invalidate();
    }
  });
}
