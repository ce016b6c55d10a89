// The plan as a whole.
export const plan = {
  changed: "The plan was changed in another tab or by somebody else.",
  takeOver: "Show it as it is now",
  contested: (changes: string) => `Changed here and in another tab, in two ways. There: ${changes}. As it is here now it is saved.`,
  mine: "Keep it as it is here",
  theirs: "Take it as it is there",
};
