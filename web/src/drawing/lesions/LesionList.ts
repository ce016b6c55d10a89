// The lesions of a result that is only looked at: each a button that shows it through the skin, with what is said of it below.
import { button } from "../../ui/controls";
import { el, fill } from "../../ui/dom";
import * as text from "../text";
import { type LaidLesion } from "./lesions";

interface Shown {
  readonly laid: readonly LaidLesion[]; // as the service has them on this scan
  readonly lesion: string | null; // id of the one that is looked at
}

export function createLesionList(choose: (id: string | null) => void) {
  const list = el("ul", { class: "layers", "data-layer": "lesions" });
  return {
    element: list,
    update({ laid, lesion }: Shown): void {
      fill(list, [laid, lesion], () =>
        laid.map((each) => {
          const { id, name, radius_mm, depth_mm } = each;
          const shown = button(name, () => choose(lesion === id ? null : id), "link");
          shown.setAttribute("aria-pressed", String(lesion === id));
          const row = el("li", { "data-line": name }, shown, el("span", { class: "muted small" }, text.lesions.says(radius_mm, depth_mm)));
          if (lesion === id) void Promise.all([import("./LesionView"), import("./SlicePictures")]).then(([{ lesionView }, { slicePictures }]) => row.append(lesionView(each, null, null), slicePictures(each)));
          return row;
        }),
      );
    },
  };
}
