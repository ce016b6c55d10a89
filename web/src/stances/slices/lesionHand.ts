// A lesion under the hand in the slices: made by three taps (its centre, and its edge twice), moved with the cross, resized.
import type { PlanLesion, Vector } from "../../api/types";
import { itemKey } from "../../drawing/panel/items";
import { lesionAt, markedBall, RADIUS_MM } from "../../drawing/lesions/lesions";
import { initialSlices, type SlicesState } from "../../drawing/slices/state";
import { lesions as lesionWords } from "../../drawing/text";
import { lesionsIn, type SeenLesion, slicedOf, type SlicesShown } from "./shown";
import { hand as words } from "./text";

const KEY_MM = 0.5;

export interface LesionActions {
  slices(change: Partial<SlicesState>): void;
  lesions(own: readonly PlanLesion[]): void;
  choose(item: string): void;
}

export function createLesionHand(actions: LesionActions, now: () => SlicesShown, changed: () => void) {
  let pointed: Vector | null = null; // where the next tap would be
  let radius: number | null = null; // that the hand gives it just now

  const marks = (): readonly Vector[] | null => now().slices.marks;
  /** The one that goes where the cross goes. */
  const held = (): SeenLesion | null => {
    const lesion = now().slices.moves ? (lesionsIn(slicedOf(now()).of).find(({ id, isOwn }) => id === now().lesion && isOwn) ?? null) : null;
    return lesion && radius !== null ? { ...lesion, radius } : lesion;
  };
  const within = (mm: number): number => Math.round(10 * Math.min(Math.max(mm, RADIUS_MM.least), RADIUS_MM.most)) / 10;

  function change(part: Partial<PlanLesion>): void {
    const lesion = held();
    if (lesion) actions.lesions(now().drawn.lesions.map((each) => (each.id === lesion.id ? { ...each, ...part } : each)));
  }

  return {
    held,
    isMarking: (): boolean => marks() !== null,
    moved: (center: Vector): void => change({ center: [...center] }),

    /** While its edge is dragged, and when that is over. */
    resize(mm: number, isOver: boolean): void {
      radius = isOver ? null : within(mm);
      if (isOver) change({ radius_mm: within(mm) });
      else changed();
    },

    begin: (): void => actions.slices({ marks: [], moves: false }),

    /** One of the three places; with the third it is in the plan. */
    tap(place: Vector): void {
      const all = [...(marks() ?? []), place];
      pointed = null;
      if (all.length < 3) return actions.slices({ marks: all, ...(all.length === 1 ? { cross: { scan: now().scan!.info.id, at: place } } : {}) });
      const { drawn } = now();
      const { center, radius } = markedBall(all);
      const made = lesionAt(lesionWords.numbered(drawn.lesions.length + 1), center, within(radius));
      actions.slices({ marks: null });
      actions.lesions([...drawn.lesions, made]);
      actions.choose(itemKey.lesion(made.id));
    },

    hover(place: Vector | null): void {
      if (marks() === null || marks()!.length === 0) return;
      pointed = place;
      changed();
    },

    /** Brackets make it smaller and larger; Enter is a tap at the cross, Escape ends the marking. */
    key({ key }: KeyboardEvent, cross: Vector): boolean {
      const lesion = held();
      const way = { "[": -1, "]": 1 }[key] ?? 0;
      if (marks() !== null && key === "Enter") this.tap(cross);
      else if (marks() !== null && key === "Escape") actions.slices({ marks: initialSlices.marks });
      else if (lesion && way !== 0) change({ radius_mm: within(lesion.radius + way * KEY_MM) });
      else return false;
      return true;
    },

    /** What is drawn of it before it is made. */
    sketch(): SeenLesion | null {
      const all = [...(marks() ?? []), ...(pointed ? [pointed] : [])];
      if (all.length < 2) return null;
      return { id: "", name: "", ...markedBall(all), reach: null, isOwn: true, laid: null };
    },

    says(): string {
      const lesion = held();
      const count = marks()?.length;
      return count !== undefined ? words.marking[count]! : lesion ? words.moving(lesion.name, lesion.radius) : "";
    },
  };
}
