// Every English sentence of the page, in one folder, ready for translation: another language is another folder like this.
// Names and definitions of landmarks, shapes and drawings come from the model, notes and reasons from the service.
import { drawing } from "./drawing";
import { errors } from "./errors";
import { fit, timeline } from "./fit";
import { help } from "./help";
import { landmarks, proposals } from "./landmarks";
import { look } from "./look";
import { page, top, next } from "./page";
import { picture } from "./picture";
import { result, distances, numbers } from "./result";
import { empty, units, loading, scan } from "./scan";
import { share, shared } from "./share";
import { stances } from "./stances";
import { view } from "./view";

export const text = {
  ...page,
  top,
  next,
  empty,
  units,
  loading,
  scan,
  landmarks,
  proposals,
  fit,
  timeline,
  drawing,
  result,
  distances,
  look,
  picture,
  numbers,
  share,
  shared,
  stances,
  view,
  help,
  errors,
};
