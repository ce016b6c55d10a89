// The sentences of LesionView.ts, which come with it.
import { word } from "../../languages/words";
import { formatMmWhole } from "../../ui/units";
import { drawing } from "../text";

const fromNipple = new RegExp(`${word("drawing.lesions.lesionView.fromNipple")}$`); // as the service ends its sentence

export const lesionView = {
  to: ({ kind, to, seen }: { kind: string; to: string; seen?: boolean }) => ({ nipple: word("drawing.lesions.lesionView.toNipple"), chest_wall: word(seen ? "drawing.lesions.lesionView.toWallSeen" : "drawing.lesions.lesionView.toWall"), line: word("drawing.lesions.lesionView.toLine", { line: drawing.shapeName(to) }) })[kind] ?? to,
  banded: ({ mm, low_mm: low, high_mm: high }: { mm: number; low_mm: number | null; high_mm: number | null }) => (low === null || high === null ? word("drawing.lesions.lesionView.plain", { mm: formatMmWhole(mm) }) : word("drawing.lesions.lesionView.banded", { mm: formatMmWhole(mm), low: formatMmWhole(low), high: formatMmWhole(high) })),
  place: word("drawing.lesions.lesionView.place"),
  clock: word("drawing.lesions.lesionView.clock"),
  byClock: (text: string) => text.replace(fromNipple, ""), // which stands above it
  name: word("drawing.lesions.lesionView.name"),
  radiology: word("drawing.lesions.lesionView.radiology"),
  radiologyHint: word("drawing.lesions.lesionView.radiologyHint"),
  placed: ({ carried, error_mm: error }: { carried: boolean; error_mm: number | null }) => [...(carried ? [word("drawing.lesions.lesionView.carried")] : []), error === 0 ? word("drawing.lesions.lesionView.asGiven") : error === null ? word("drawing.lesions.lesionView.errorUnknown") : `±\u00a0${formatMmWhole(error)}\u00a0mm`].join(", "),
  unseen: word("drawing.lesions.lesionView.unseen"),
  skin: word("drawing.lesions.lesionView.skin"),
  wall: (isSeen: boolean) => word(isSeen ? "drawing.lesions.lesionView.wallSeen" : "drawing.lesions.lesionView.wall"),
  depth(depth: number, { mm, low_mm: low, high_mm: high }: { mm: number; low_mm: number | null; high_mm: number | null }) {
    const number = `${formatMmWhole(mm)}\u00a0mm`;
    const band = low === null || high === null ? "" : `90\u00a0%: ${formatMmWhole(low)}–${formatMmWhole(high)}\u00a0mm`;
    const where = word(depth < 0 ? "drawing.lesions.lesionView.outside" : "drawing.lesions.lesionView.below", { number });
    return { mm: number, band, whole: band === "" ? where : `${where} (${band})` };
  },
  planes: { axial: word("drawing.lesions.lesionView.planes.axial"), sagittal: word("drawing.lesions.lesionView.planes.sagittal"), coronal: word("drawing.lesions.lesionView.planes.coronal") } as const,
  sides: { axial: word("drawing.lesions.lesionView.sides.axial"), sagittal: word("drawing.lesions.lesionView.sides.sagittal"), coronal: word("drawing.lesions.lesionView.sides.coronal") } as const,
  slice: (plane: string, name: string) => word("drawing.lesions.lesionView.slice", { plane, name }),
  slicesHint: word("drawing.lesions.lesionView.slicesHint"),
  noSlices: word("drawing.lesions.lesionView.noSlices"),
  straight: word("drawing.lesions.lesionView.straight"),
  moves: word("drawing.lesions.lesionView.moves"),
  moveIt: (name: string) => word("drawing.lesions.lesionView.moveIt", { name }),
};
