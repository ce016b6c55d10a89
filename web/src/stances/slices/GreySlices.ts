// The image below the slices: a canvas in each, of which the browser zooms; window and level by the right button, keys and two
// sliders.  The voxels come when slices of an image are opened, and are given back when they are closed.
import type { Scan, ScanImage } from "../../api/types";
import type { Flat, View } from "../../drawing/slices/section";
import { messageOf } from "../../store/problems";
import { button } from "../../ui/controls";
import { el, show } from "../../ui/dom";
import { createMenu } from "../../ui/menu";
import { type Grey, greyOf, type Grid, gridOf, resample, shades, USUAL, type Window, windowed } from "./grey";
import { grey as words } from "./text";

const PIXEL = 0.6; // of 255, for each that the right button is dragged by
const KEY = 12;

/** What a pane shows: mm a pixel, and the place in its middle. */
export interface SeenAt {
  readonly mm: number;
  readonly middle: Flat;
  readonly width: number;
  readonly height: number;
}

/** `changed`: draw again; `says`: what has to be said while there is no image, "" when there is. */
export function createGreySlices(volume: (scan: Scan) => Promise<ArrayBuffer>, changed: () => void, says: (sentence: string) => void) {
  let of: string | null = null; // id of the scan whose image is here, or on its way
  let grey: Grey | null = null;
  let window = USUAL;
  let colours = shades(window);

  const slider = (name: keyof Window, most: number): HTMLInputElement =>
    el("input", { type: "range", class: "slider", min: 5, max: most, "aria-label": words[name], oninput: (event) => look({ ...window, [name]: (event.target as HTMLInputElement).valueAsNumber }) });
  const sliders = { level: slider("level", 250), width: slider("width", 510) };
  const rows = (["level", "width"] as const).map((name) => el("label", { class: "window-row" }, el("span", {}, words[name]), sliders[name]));
  const menu = createMenu("window-menu", words.window, words.hint, "quiet", ...rows, el("p", { class: "muted small" }, words.how), button(words.reset, () => look(USUAL), "outlined"));
  const control = el("div", { class: "slices-window", hidden: true }, menu.element);

  function look(now: Window): void {
    window = windowed(now);
    colours = shades(window);
    for (const name of ["level", "width"] as const) {
      sliders[name].value = String(Math.round(window[name]));
      sliders[name].setAttribute("aria-valuetext", words.share(window[name]));
    }
    changed();
  }

  /** Of this scan from now on; null: of none. */
  function follow(scan: Scan | null): void {
    const image = scan?.image ?? null;
    const id = image ? (scan?.id ?? null) : null;
    show(control, id !== null);
    if (of === id) return;
    of = id;
    grey = null;
    changed();
    if (scan && image) void load(scan, image);
    else says("");
  }

  async function load(scan: Scan, image: ScanImage): Promise<void> {
    says(words.coming);
    let why = words.damaged;
    const now = await volume(scan).then((bytes) => greyOf(bytes, image), (error: unknown) => ((why = messageOf(error)), null));
    if (of !== scan.id) return;
    grey = now;
    says(now ? "" : words.unseen(why));
    look(USUAL);
  }

  return {
    control,
    follow,
    isThere: (): boolean => grey !== null,

    /** Comma and full stop darken and lighten, with Shift they take and give contrast. */
    key({ code, key, shiftKey }: KeyboardEvent): boolean {
      const way = { Comma: 1, Period: -1 }[code] ?? 0;
      if (!grey || (way === 0 && key !== "0")) return false;
      look(way === 0 ? USUAL : shiftKey ? { ...window, width: window.width + way * KEY } : { ...window, level: window.level + way * KEY });
      return true;
    },

    /** The canvas of one pane; `picture` is what is dragged over. */
    pane(picture: SVGElement) {
      const element = el("canvas", { class: "slice-grey", "aria-hidden": "true", hidden: true });
      const context = element.getContext("2d");
      let made: { readonly of: Grey; readonly where: string; readonly grid: Grid; readonly values: Uint8Array } | null = null;
      let shown: { readonly made: object; readonly colours: object } | null = null;

      picture.addEventListener("contextmenu", (event) => grey && event.preventDefault());
      picture.addEventListener("pointerdown", (event) => {
        if (event.button !== 2 || !grey) return;
        const start = window;
        const over = new AbortController();
        picture.setPointerCapture(event.pointerId);
        picture.addEventListener("pointermove", (now) => look({ level: start.level - PIXEL * (now.clientY - event.clientY), width: start.width + PIXEL * (now.clientX - event.clientX) }), over);
        for (const type of ["pointerup", "pointercancel"] as const) picture.addEventListener(type, () => over.abort(), over);
      });

      /** Its memory is given back. */
      function release(): void {
        made = shown = null;
        element.width = element.height = 0;
      }

      return {
        element,
        release,
        draw(view: View, offset: number, { mm, middle, width, height }: SeenAt): void {
          show(element, grey !== null);
          if (!grey || !context) return release();
          const where = JSON.stringify([offset.toFixed(2), view]);
          if (made?.where !== where || made.of !== grey) {
            const grid = gridOf(grey, view);
            const size = grid.wide * grid.high;
            const values = made?.values.length === size ? made.values : new Uint8Array(size);
            resample(grey, view, offset, grid, values);
            made = { of: grey, where, grid, values };
          }
          const { grid, values } = made;
          if (shown?.made !== made || shown.colours !== colours) {
            shown = { made, colours };
            if (element.width !== grid.wide) element.width = grid.wide;
            if (element.height !== grid.high) element.height = grid.high;
            const image = context.createImageData(grid.wide, grid.high);
            const pixels = new Uint32Array(image.data.buffer);
            for (let i = 0; i < values.length; i += 1) pixels[i] = colours[values[i]!]!;
            context.putImageData(image, 0, 0);
          }
          element.style.transform = `translate(${(width / 2 + (grid.left - middle[0]) / mm).toFixed(2)}px, ${(height / 2 + (middle[1] - grid.top) / mm).toFixed(2)}px) scale(${(grid.step / mm).toFixed(5)})`;
        },
      };
    },
  };
}
