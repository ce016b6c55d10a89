// Words that every room uses.  Each room has a text.ts of its own with all of its sentences, ready for translation: another
// language is another set of these files.  Names and definitions of landmarks, shapes and drawings come from the model,
// notes and reasons from the service.

export const name = "BreastRig";
export const notice = "Research use only. Not a medical device.";
export const noticeLong =
  "Research use only. Not a medical device; not for diagnosis, treatment or surgical decisions. " +
  "Measurements carry scanner and fitting error.";
export const dismiss = "Dismiss";
export const close = "Close";
