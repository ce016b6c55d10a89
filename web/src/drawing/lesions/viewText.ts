// The sentences of LesionView.ts, which come with it.
import { drawing } from "../text";

export const lesionView = {
  to: ({ kind, to, seen }: { kind: string; to: string; seen?: boolean }) => ({ nipple: "To the nipple", chest_wall: `To the chest wall${seen ? " of the image" : ""}`, line: `To ${drawing.shapeName(to)}` })[kind] ?? to,
  banded: ({ mm, low_mm: low, high_mm: high }: { mm: number; low_mm: number | null; high_mm: number | null }) => `${mm.toFixed(0)}\u00a0mm${low === null || high === null ? "" : `, ${low.toFixed(0)} to ${high.toFixed(0)}`}`,
  place: "Its place",
  clock: "By the clock",
  byClock: (text: string) => text.replace(/ from the nipple$/, ""), // which stands above it
  name: "Name",
  radiology: "What radiology wrote",
  radiologyHint: "left, 2 o'clock, 45 mm",
  placed: ({ carried, error_mm: error }: { carried: boolean; error_mm: number | null }) => [...(carried ? ["carried"] : []), error === 0 ? "as given" : error === null ? "how far off is not known" : `±\u00a0${error.toFixed(0)}\u00a0mm`].join(", "),
  unseen: "The scan shows no skin there: how deep it lies is the model's guess.",
  skin: "skin",
  wall: (isSeen: boolean) => `chest wall, ${isSeen ? "from the image" : "estimated"}`,
  depth(depth: number, { mm, low_mm: low, high_mm: high }: { mm: number; low_mm: number | null; high_mm: number | null }) {
    const number = `${mm.toFixed(0)}\u00a0mm`;
    const band = low === null || high === null ? "" : `90\u00a0%: ${low.toFixed(0)}–${high.toFixed(0)}\u00a0mm`;
    const where = `${number} ${depth < 0 ? "outside" : "below"} the skin`;
    return { mm: number, band, whole: band === "" ? where : `${where} (${band})` };
  },
  planes: { axial: "Axial", sagittal: "Sagittal", coronal: "Coronal" } as const,
  sides: { axial: "front up, patient's left right", sagittal: "head up, back right", coronal: "head up, patient's left right" } as const,
  slice: (plane: string, name: string) => `${plane} slice through ${name}`,
  slicesHint: "The fitted skin, 20\u00a0cm across; dashed the chest wall, estimated where the image does not show it; pale where the lesion may lie, nine times in ten.",
  noSlices: "No slices: this link shows the model alone, and no skin of the patient.",
  straight: "From its centre, straight.",
  moves: "While it is moved, dragging and arrow keys in the slices take it along.",
  moveIt: (name: string) => `Move ${name}`,
};
