// The sentences of LesionView.ts, which come with it.
import { drawing } from "../text";

export const lesionView = {
  to: ({ kind, to }: { kind: string; to: string }) => ({ skin: "Below the skin", nipple: "To the nipple", chest_wall: "To the chest wall", line: `To ${drawing.shapeName(to)}` })[kind] ?? to,
  banded: ({ mm, low_mm: low, high_mm: high }: { mm: number; low_mm: number | null; high_mm: number | null }) => `${mm.toFixed(0)}\u00a0mm${low === null || high === null ? "" : `, ${low.toFixed(0)} to ${high.toFixed(0)}`}`,
  place: "Its place",
  placed: ({ carried, error_mm: error }: { carried: boolean; error_mm: number | null }) => [...(carried ? ["carried"] : []), error === 0 ? "as given" : error === null ? "how far off is not known" : `±\u00a0${error.toFixed(0)}\u00a0mm`].join(", "),
  unseen: "The scan shows no skin there: how deep it lies is the model's guess.",
  slice: (plane: string) => `${plane} slice`,
  slices: "From its centre, straight; nine of ten true values lie in the second numbers. Pale: how far it may reach. Patient's left is right.",
  slicesMove: "From its centre, straight; nine of ten true values lie in the second numbers. Patient's left is right. Drag it in a slice, or use the arrow keys.",
};
