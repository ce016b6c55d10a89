// 30 centimetres beside the body, a tick each, so that a wrong unit is seen at once.
import { BufferAttribute, BufferGeometry, LineBasicMaterial, LineSegments, Vector3 } from "three";
import type { PageSlice } from "../store/page";
import { el } from "../ui/dom";
import type { Part, Viewer } from "../viewer/Viewer";
import type { ScanSlice } from "./state";
import * as text from "./text";

type Shown = Pick<ScanSlice & PageSlice, "scan" | "step">;

const LENGTH_CM = 30;
const AWAY = 0.07; // metres beside the body

export class Ruler implements Part<Shown> {
  private readonly lines: LineSegments<BufferGeometry, LineBasicMaterial>;
  private readonly label = el("div", { class: "ruler-label", hidden: true }, text.scan.ruler);

  constructor(private readonly viewer: Viewer) {
    const points = [0, 0, 0, 0, LENGTH_CM / 100, 0];
    for (let cm = 0; cm <= LENGTH_CM; cm += 1) {
      const tick = cm % 10 === 0 ? 0.018 : cm % 5 === 0 ? 0.012 : 0.006;
      points.push(0, cm / 100, 0, -tick, cm / 100, 0);
    }
    const geometry = new BufferGeometry().setAttribute("position", new BufferAttribute(new Float32Array(points), 3));
    this.lines = new LineSegments(geometry, new LineBasicMaterial());
    viewer.scene.add(this.lines); // upright in the view, whatever the scan's axes
    viewer.overlay.append(this.label);
    viewer.beforeFrame.add(() => this.place());
  }

  update(state: Shown): void {
    const isShown = state.scan !== null && state.step === "scan";
    this.lines.visible = isShown;
    this.label.hidden = !isShown;
    this.lines.material.color.copy(this.viewer.palette.ruler);
  }

  private place(): void {
    const { half, body } = this.viewer;
    this.lines.position.set(-half.x - AWAY, -half.y, 0);
    const top = this.lines.position.clone().add(new Vector3(0, LENGTH_CM / 100 + 0.012, 0));
    const { x, y } = this.viewer.toScreen(body.worldToLocal(top));
    this.label.style.transform = `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px)`;
  }
}
