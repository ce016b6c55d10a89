// The sentences of the slices, which come with them.
import type { Plane } from "../../drawing/slices/state";

interface Ways { readonly left: number; readonly up: number; readonly front: number } // mm from the scan's zero

const along = (mm: number, [more, less]: readonly [string, string]): string => `${Math.abs(Math.round(mm))}\u00a0mm ${Math.round(mm) < 0 ? less : more}`;
const LEFT = ["left", "right"] as const;
const FRONT = ["front", "back"] as const;
const UP = ["head", "feet"] as const;

export const slices = {
  group: "Slices",
  names: { axial: "Axial", sagittal: "Sagittal", coronal: "Coronal", body: "Body" } satisfies Record<Plane | "body", string>,
  picture: (plane: string, hasImage: boolean) => `${plane} slice. Arrow keys move the cross by 1 mm, with Shift by 5; Page Up and Page Down go through the slices; plus and minus zoom; ${hasImage ? "comma and full stop darken and lighten its image; " : ""}Enter enlarges.`,
  through: (plane: string) => `Place of the ${plane.toLowerCase()} slice`,
  /** Where a slice lies, in its corner and for its slider. */
  at: (plane: Plane, { left, up, front }: Ways): string => (plane === "axial" ? along(up, UP) : plane === "sagittal" ? along(left, LEFT) : along(front, FRONT)),
  edges: {
    axial: { top: "Front", bottom: "Back", left: "R", right: "L" },
    sagittal: { top: "Head", bottom: "Feet", left: "Front", right: "Back" },
    coronal: { top: "Head", bottom: "Feet", left: "R", right: "L" },
  } satisfies Record<Plane, Record<"top" | "bottom" | "left" | "right", string>>,
  side: (middle: number) => (Math.abs(middle) < 5 ? "in the middle" : `patient's ${middle > 0 ? "left" : "right"}`),
  enlarge: (name: string) => `Enlarge ${name.toLowerCase()} (double tap)`,
  all: "All four",
  close: "Close the slices (Esc)",
  place: ({ left, up, front }: Ways, lesion: string): string => `Cross ${along(left, LEFT)}, ${along(front, FRONT)}, ${along(up, UP)} of the scan's zero${lesion}.`,
  inLesion: (name: string) => `, in ${name}`,
  nearLesion: (name: string, mm: number) => `, ${Math.round(mm)}\u00a0mm from the centre of ${name}`,
  unseen: "This scan's surface cannot be shown.",
};

export const grey = {
  window: "Window",
  hint: "How light the image is",
  level: "Level",
  width: "Width",
  share: (of255: number) => `${Math.round((100 * of255) / 255)}\u00a0%`,
  how: "Or drag in a slice with the right mouse button: up and down for the level, sideways for the width.",
  reset: "As it came",
  coming: "The image is coming …",
  damaged: "The image arrived damaged; open the slices again.",
  unseen: (why: string) => `The image cannot be shown: ${why}`,
};

export const hand = {
  mark: "Mark a lesion",
  markHint: "By three taps: its centre, then its edge twice",
  marking: ["Tap the lesion's centre (or put the cross there and press Enter).", "Tap its edge.", "Tap its edge at another place, in any slice."],
  moving: (name: string, radius: number) => `Dragging and arrow keys move ${name}; its handle, or [ and ], its radius: ${Number(radius.toFixed(1))}\u00a0mm.`,
};
