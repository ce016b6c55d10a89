// The bottom: every iteration again, by slider or as a replay.
import { only } from "../../store/store";
import { el, icon, setText, show } from "../../ui/dom";
import type { Panel } from "../../ui/Panel";
import { formatMm } from "../../ui/units";
import type { Player } from "./playback";
import { type FitSlice, isAtRest, shownIteration } from "../state";
import * as text from "../text";

type Shown = Pick<FitSlice, "fit">;

export function createTimeline(player: Player): Panel<Shown> {
  const slider = el("input", {
    type: "range",
    class: "slider",
    min: 0,
    step: 1,
    id: "iteration",
    oninput: () => player.seek(Number(slider.value)),
  });
  const position = el("output", { class: "position", for: "iteration", "aria-live": "off" });
  const mean = el("span", { class: "mean muted" });
  const words = el("span", {});
  const play = el("button", { type: "button", class: "button quiet outlined", id: "replay", onclick: () => player.toggle() });
  const element = el("section", { class: "timeline", "aria-label": text.timeline.label, hidden: true }, el("label", { for: "iteration" }, text.timeline.label), slider, position, mean, play);
  let drawn = "";
  return {
    element,
    select: only("fit"),
    update(state: Shown): void {
      const { fit } = state;
      const last = (fit?.iterations.length ?? 0) - 1;
      show(element, last >= 0);
      if (!fit || last < 0) return;
      slider.max = String(last);
      slider.value = String(Math.max(0, fit.shown));
      slider.disabled = last === 0;
      const shown = shownIteration(fit);
      const end = fit.iterations.at(-1);
      const where = text.timeline.position(String(shown?.iteration ?? 0), String(end?.iteration ?? 0));
      setText(position, where);
      slider.setAttribute("aria-valuetext", where);
      const result = isAtRest(fit) ? fit.result : null; // its mean is taken after the last step and counts
      const distance = result ? result.surface_distance_mm.mean : shown?.mean_distance_mm;
      setText(mean, distance === undefined ? "" : text.timeline.mean(formatMm(distance)));
      play.disabled = last === 0;
      const label = fit.playing ? "pause" : fit.shown < last ? "play" : "replay";
      if (drawn !== label) {
        drawn = label;
        setText(words, text.timeline[label]);
        play.replaceChildren(icon(fit.playing ? "pause" : "play"), words);
      }
    },
  };
}
