// "Standing, a woman, 53 cm tall, facing you": what was read and decided, each word a button that corrects it.
import type { StanceChoice, UnitChoice } from "../../api/types";
import { isStanceAsked } from "../../fit/verdict";
import { stanceOf } from "../../stances/state";
import { only } from "../../store/store";
import { el, fill, show } from "../../ui/dom";
import { createMenu, menuItem } from "../../ui/menu";
import type { Panel } from "../../ui/Panel";
import { formatCm, mmFrom, toUnit } from "../../ui/units";
import { isVolume } from "../../scan/state";
import { models as modelNames, units as unitNames } from "../../scan/text";
import { sizeIn, type Turn } from "../../viewer/frame";
import type { Actions } from "../actions";
import type { Session } from "../session";
import { sentence as words } from "../text";

type Shown = Pick<Session, "meta" | "scan" | "stance" | "fit" | "isStarting">;

const UNITS = ["mm", "cm", "dm", "m", "in", "ft"] as const satisfies readonly UnitChoice[];
const TURNS: readonly Turn[] = ["around", "sideways", "forwards"];
const STANCES = ["standing", "supine", "prone"] as const satisfies readonly StanceChoice[];

export function createSentence(actions: Actions): Panel<Shown> {
  const choose = (stance: StanceChoice): void => actions.fit.chooseStance(stance);
  const stance = createMenu("stance-word", "", words.stance, "word", ...STANCES.map((each) => menuItem(words.stances[each], "", () => choose(each))));
  const model = createMenu("model-word", "", words.model, "word");
  const size = createMenu("size-word", "", words.unit, "word");
  const facing = createMenu("facing-word", "", words.direction, "word", ...TURNS.map((turn) => menuItem(words.turns[turn], "", () => actions.scan.turn(turn))));
  for (const each of [stance, model, size]) each.card.addEventListener("click", () => each.close());
  const comma = (of: { readonly element: HTMLElement }): HTMLElement => el("span", { class: "phrase" }, of.element, ",");
  const ofModel = comma(model);
  const element = el("div", { class: "panel" }, el("p", { class: "sentence", role: "group", "aria-label": words.label }, comma(stance), ofModel, comma(size), el("span", { class: "phrase" }, facing.element)));
  return {
    element,
    select: only("meta", "scan", "stance", "fit", "isStarting"),
    update(state: Shown): void {
      const { meta, scan } = state;
      if (!scan) return;
      const { info, frame, frameFrom, file } = scan;
      const now = stanceOf(state);
      const isAsked = isStanceAsked(state.fit?.result) && state.stance === "auto";
      stance.set(words.stances[now]);
      stance.open.classList.toggle("is-asked", isAsked);
      const models = meta?.models ?? [];
      show(ofModel, models.length > 1);
      const isGuess = info.model === models[0] && !info.model_said; // which the service takes where nobody says
      const named = words.models[info.model] ?? info.model;
      model.set(isGuess ? words.guess(named) : named);
      fill(model.card, [models, info.model, isGuess, file === null], () => {
        const offered = file === null ? [info.model] : models;
        const items = offered.map((name) => {
          const item = menuItem(modelNames[name] ?? name, isGuess && name === info.model ? words.guessed : "", () => (name === info.model ? void actions.scan.confirmModel() : void actions.bring.again({ model: name })));
          item.setAttribute("aria-pressed", String(name === info.model && !isGuess));
          return item;
        });
        return file === null ? [...items, el("p", { class: "muted small" }, words.modelFile)] : items;
      });
      const isImage = isVolume(info);
      const lies = now !== "standing";
      const tall = info.size_m ? sizeIn(frame, info.frame, info.size_m)[1] : null;
      show(size.element.parentElement!, tall !== null);
      if (tall !== null) {
        size.set(words.size(formatCm(tall), lies));
        fill(size.card, [info.id, info.unit, tall, lies, file === null], () =>
          isImage || file === null
            ? [el("p", { class: "muted small" }, isImage ? words.imageUnit : words.otherFile)]
            : UNITS.map((unit) => {
                const item = menuItem(unitNames[unit], unit === info.unit ? "" : words.asUnit(formatCm(mmFrom(toUnit(1000 * tall, info.unit), unit) / 1000), lies), () => void actions.bring.again({ units: unit }));
                item.setAttribute("aria-pressed", String(unit === info.unit));
                return item;
              }),
        );
      }
      facing.set(frameFrom === "person" ? words.turned : words.facing[now]);
    },
  };
}
