// From which side the body is seen, and what of scan and model is shown.

export type Overlay = "scan" | "both" | "model";
export const OVERLAYS: readonly Overlay[] = ["scan", "both", "model"];
/** What can be switched beside scan and model. */
export const LOOKS = ["distances", "mirror", "relief", "loose", "colours", "linked", "slices"] as const;
export type Look = (typeof LOOKS)[number];
export type ViewName = "front" | "left" | "right" | "back" | "top";

export interface ViewSlice {
  readonly overlay: Overlay;
  readonly view: { readonly name: ViewName; readonly asked: number };
  readonly graphics: "ok" | "absent" | "lost";
  readonly otherGraphics: "ok" | "lost"; // of the second pane
}

export const initialView: ViewSlice = { overlay: "scan", view: { name: "front", asked: 0 }, graphics: "ok", otherGraphics: "ok" };

/** The body seen from the front again, as after a turn. */
export const fromFront = ({ view }: Pick<ViewSlice, "view">): Pick<ViewSlice, "view"> => ({ view: { name: "front", asked: view.asked + 1 } });
