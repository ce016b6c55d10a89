// What a patient's visits show over time.
import { word } from "../../languages/words";

export const visits = {
  title: word("stances.visits.title"),
  what: word("stances.visits.what"),
  day: word("stances.visits.day"),
  name: word("stances.visits.name"),
  names: [word("stances.visits.before"), word("stances.visits.theatre"), word("stances.visits.sixWeeks"), word("stances.visits.sixMonths"), word("stances.visits.year")],
  asked: word("stances.visits.asked"),
  busy: word("stances.visits.busy"),
  none: word("stances.visits.none"),
  plots: (stance: string) => word("stances.visits.plots", { stance }),
  between: (stance: string, earlier: string, later: string) => word("stances.visits.between", { stance, earlier, later }),
  volume: (side: string, ml: string) => word("stances.visits.volume", { side, ml }),
  left: word("stances.visits.left"),
  right: word("stances.visits.right"),
  largest: (side: string, mm: string, band: string) => word("stances.visits.largest", { side, mm, band }),
  unsaid: (side: string, band: string) => word("stances.visits.unsaid", { side, band }),
  map: word("stances.visits.map"),
  file: "change.glb",
};
