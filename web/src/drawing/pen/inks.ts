// The markers that lie beside the full canvas.  Each is distinguished from the others by people who do not see colours alike, and
// has a name for those who do not see them at all.
import { INK } from "../lines/lines";
import { canvas } from "../text";

export const INKS: readonly { readonly color: string; readonly name: string }[] = [
  { color: INK, name: canvas.colours.black },
  { color: "#c53030", name: canvas.colours.red },
  { color: "#2b6cb0", name: canvas.colours.blue },
  { color: "#2f855a", name: canvas.colours.green },
  { color: "#dd6b20", name: canvas.colours.orange },
  { color: "#f4f4f4", name: canvas.colours.white },
];
