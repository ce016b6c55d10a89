// A small cube that turns with the body: which side one looks at, and a click away from each of the others.
// DOM and CSS instead of 3D: its letters stay sharp, and it needs no second picture.  The buttons below the body do the
// same for keys and screen readers, hence the cube is hidden from them.
import { Matrix4 } from "three";
import { el } from "../ui/dom";
import type { ViewName } from "./state";
import * as text from "./text";
import type { Part, Viewer } from "./Viewer";

const SIDES: readonly ViewName[] = ["front", "back", "left", "right", "top"];

export class OrientationCube implements Part<{ readonly scan: object | null; readonly loading: object | null }> {
  private readonly cube = el("div", { class: "cube-body" }, ...SIDES.map((side) => this.face(side)), el("span", { class: "cube-face is-bottom" }));
  private readonly element = el("div", { class: "cube", "aria-hidden": "true", hidden: true }, this.cube);

  constructor(
    private readonly viewer: Viewer,
    private readonly lookFrom: (side: ViewName) => void,
  ) {
    viewer.overlay.append(this.element);
    viewer.beforeFrame.add(() => this.turn());
  }

  update({ scan, loading }: { readonly scan: object | null; readonly loading: object | null }): void {
    this.element.hidden = scan === null || loading !== null;
  }

  private face(side: ViewName): HTMLElement {
    const pressed = (): void => this.lookFrom(side);
    return el("button", { type: "button", tabindex: -1, class: `cube-face is-${side}`, title: text.view.hints[side], onclick: pressed }, text.view.faces[side]);
  }

  private turn(): void {
    if (this.element.hidden) return;
    const turn = new Matrix4().extractRotation(this.viewer.camera.matrixWorldInverse).elements;
    // A style sheet counts downwards what the scene counts upwards: the second axis changes its sign on both sides.
    const at = (row: number, column: number): number => turn[4 * column + row]! * ((row === 1) === (column === 1) ? 1 : -1);
    const cells = [0, 1, 2].flatMap((column) => [at(0, column), at(1, column), at(2, column), 0]);
    this.cube.style.transform = `matrix3d(${cells.map((cell) => cell.toFixed(5)).join(",")},0,0,0,1)`;
  }
}
