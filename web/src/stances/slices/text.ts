// The sentences of the slices, which come with them.
import { inSentence, type Key, word } from "../../languages/words";
import { formatUpTo } from "../../ui/units";
import type { Plane } from "../../drawing/slices/state";

interface Ways { readonly left: number; readonly up: number; readonly front: number } // mm from the scan's zero

const along = (mm: number, [more, less]: readonly [Key, Key]): string => word(Math.round(mm) < 0 ? less : more, { mm: Math.abs(Math.round(mm)) });
const LEFT = ["stances.slices.toLeft", "stances.slices.toRight"] as const;
const FRONT = ["stances.slices.toFront", "stances.slices.toBack"] as const;
const UP = ["stances.slices.toHead", "stances.slices.toFeet"] as const;

export const slices = {
  group: word("stances.slices.group"),
  names: { axial: word("stances.slices.names.axial"), sagittal: word("stances.slices.names.sagittal"), coronal: word("stances.slices.names.coronal"), body: word("stances.slices.names.body") } satisfies Record<Plane | "body", string>,
  picture: (plane: string, hasImage: boolean) => word(hasImage ? "stances.slices.pictureOfImage" : "stances.slices.picture", { plane }),
  through: (plane: string) => word("stances.slices.through", { plane: inSentence(plane) }),
  /** Where a slice lies, in its corner and for its slider. */
  at: (plane: Plane, { left, up, front }: Ways): string => (plane === "axial" ? along(up, UP) : plane === "sagittal" ? along(left, LEFT) : along(front, FRONT)),
  edges: {
    axial: { top: word("stances.slices.edges.axial.top"), bottom: word("stances.slices.edges.axial.bottom"), left: word("stances.slices.edges.axial.left"), right: word("stances.slices.edges.axial.right") },
    sagittal: { top: word("stances.slices.edges.sagittal.top"), bottom: word("stances.slices.edges.sagittal.bottom"), left: word("stances.slices.edges.sagittal.left"), right: word("stances.slices.edges.sagittal.right") },
    coronal: { top: word("stances.slices.edges.coronal.top"), bottom: word("stances.slices.edges.coronal.bottom"), left: word("stances.slices.edges.coronal.left"), right: word("stances.slices.edges.coronal.right") },
  } satisfies Record<Plane, Record<"top" | "bottom" | "left" | "right", string>>,
  side: (middle: number) => word(Math.abs(middle) < 5 ? "stances.slices.inMiddle" : middle > 0 ? "stances.slices.onLeft" : "stances.slices.onRight"),
  enlarge: (name: string) => word("stances.slices.enlarge", { name: inSentence(name) }),
  all: word("stances.slices.all"),
  close: word("stances.slices.close"),
  place: ({ left, up, front }: Ways, lesion: string): string => word("stances.slices.place", { place: [along(left, LEFT), along(front, FRONT), along(up, UP)].join(", "), lesion }),
  inLesion: (name: string) => word("stances.slices.inLesion", { name }),
  nearLesion: (name: string, mm: number) => word("stances.slices.nearLesion", { mm: Math.round(mm), name }),
  unseen: word("stances.slices.unseen"),
};

export const grey = {
  window: word("stances.slices.grey.window"),
  hint: word("stances.slices.grey.hint"),
  level: word("stances.slices.grey.level"),
  width: word("stances.slices.grey.width"),
  share: (of255: number) => word("stances.slices.grey.share", { percent: Math.round((100 * of255) / 255) }),
  how: word("stances.slices.grey.how"),
  reset: word("stances.slices.grey.reset"),
  coming: word("stances.slices.grey.coming"),
  damaged: word("stances.slices.grey.damaged"),
  unseen: (why: string) => word("stances.slices.grey.unseen", { why }),
};

export const hand = {
  mark: word("stances.slices.hand.mark"),
  markHint: word("stances.slices.hand.markHint"),
  marking: [word("stances.slices.hand.marking.1"), word("stances.slices.hand.marking.2"), word("stances.slices.hand.marking.3")],
  moving: (name: string, radius: number) => word("stances.slices.hand.moving", { name, radius: formatUpTo(radius, 1) }),
};
