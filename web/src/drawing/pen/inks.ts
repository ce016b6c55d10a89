// The markers that lie beside the full canvas.  Each is distinguished from the others by people who do not see colours alike, and
// has a name for those who do not see them at all.
import { INK } from "../lines/lines";

export const INKS: readonly { readonly color: string; readonly name: string }[] = [
  { color: INK, name: "Black" },
  { color: "#c53030", name: "Red" },
  { color: "#2b6cb0", name: "Blue" },
  { color: "#2f855a", name: "Green" },
  { color: "#dd6b20", name: "Orange" },
  { color: "#f4f4f4", name: "White" },
];
