// The plan as a whole.
export const plan = {
  changed: "The plan was changed in another tab or by somebody else.",
  takeOver: "Show it as it is now",
};
