// Every English sentence of the page, in one folder, ready for translation: another language is another folder like this.
// Names and definitions of landmarks, shapes and drawings come from the model, notes and reasons from the service.
import { drawing } from "../drawing/text";
import { errors } from "../api/text";
import { fit, timeline } from "../fit/text";
import { help } from "../app/helpText";
import { landmarks, proposals } from "../landmarks/text";
import { look } from "../fit/handPoseText";
import { page, top, next } from "../app/text";
import { picture } from "../app/exportText";
import { result, distances, numbers } from "../fit/resultText";
import { empty, units, loading, scan } from "../scan/text";
import { share, shared } from "../share/text";
import { stances } from "../stances/text";
import { view } from "../viewer/text";

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
