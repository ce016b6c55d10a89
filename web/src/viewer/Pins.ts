// Marks at places of the body, over the picture.  DOM and not 3D: always sharp, never half sunk into the skin; one behind the
// body fades.
import { Vector3 } from "three";
import type { Vector } from "../api/types";
import { metresFromMm } from "../ui/units";
import { isHidden, type Surface } from "./picking";
import type { Viewer } from "./Viewer";

interface Pin {
  readonly element: HTMLElement;
  readonly point: Vector3; // scan's frame, metres
  normal: Vector3 | null; // of the skin there; null until the scan is loaded
  at: { x: number; y: number } | null; // in the host's box; null while it is not to be seen
}

export class Pins<Key> {
  private pins = new Map<Key, Pin>();
  private held: { readonly key: Key; readonly point: Vector3 } | null = null;
  private isShown = true;

  /** `scan`: what may hide them; null: nothing does.  `reach`: pixels from a mark's middle that still hold it. */
  constructor(
    protected readonly viewer: Viewer,
    protected readonly scan: Surface | null,
    private readonly reach = 12,
  ) {
    viewer.beforeFrame.add(() => this.place());
  }

  /** One for each of these places (mm, scan's axes); `make` is asked for those that are new. */
  set(places: Iterable<readonly [Key, Vector]>, make: (key: Key) => HTMLElement): void {
    const before = this.pins;
    this.pins = new Map();
    for (const [key, at] of places) {
      const element = before.get(key)?.element ?? make(key);
      if (!before.delete(key)) this.viewer.overlay.append(element);
      this.pins.set(key, { element, point: new Vector3(...at.map(metresFromMm)), normal: null, at: null });
    }
    for (const { element } of before.values()) element.remove();
    this.viewer.invalidate();
  }

  show(isShown: boolean): void {
    this.isShown = isShown;
    for (const { element } of this.pins.values()) element.hidden = !isShown;
  }

  toggle(look: string, has: (key: Key) => boolean): void {
    for (const [key, { element }] of this.pins) element.classList.toggle(look, has(key));
  }

  /** The one under page pixels, or null. */
  at(clientX: number, clientY: number): Key | null {
    if (!this.isShown) return null;
    const box = this.viewer.host.getBoundingClientRect();
    const away = ({ at }: Pin): number => (at ? Math.hypot(at.x + box.left - clientX, at.y + box.top - clientY) : Infinity);
    const nearest = [...this.pins].sort(([, a], [, b]) => away(a) - away(b))[0];
    return nearest && away(nearest[1]) <= this.reach ? nearest[0] : null;
  }

  /** While it is dragged a mark stands elsewhere than the state says; null ends that. */
  hold(key: Key | null, point: Vector | null): void {
    this.held = key !== null && point ? { key, point: new Vector3(...point.map(metresFromMm)) } : null;
    this.viewer.invalidate();
  }

  private place(): void {
    if (!this.isShown) return;
    for (const [key, pin] of this.pins) {
      const held = this.held?.key === key ? this.held.point : null;
      const { x, y } = this.viewer.toScreen(held ?? pin.point);
      pin.element.style.transform = `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px)`;
      pin.normal ??= this.scan?.normalAt(pin.point) ?? null;
      const hidden = !held && this.scan !== null && isHidden(this.viewer, this.scan, pin.point, pin.normal);
      pin.element.classList.toggle("is-hidden", hidden);
      pin.element.classList.toggle("is-held", held !== null);
      pin.at = hidden ? null : { x, y };
    }
  }
}
