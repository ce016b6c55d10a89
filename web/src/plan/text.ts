// The plan as a whole.
import { word } from "../languages/words";

export const plan = {
  changed: word("plan.changed"),
  takeOver: word("plan.takeOver"),
  contested: (changes: string) => word("plan.contested", { changes }),
  mine: word("plan.mine"),
  theirs: word("plan.theirs"),
};
