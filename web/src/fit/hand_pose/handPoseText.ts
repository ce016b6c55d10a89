// The model's own shape: sliders that pose what is shown.

export const handPose = {
  title: "Shape of the model",
  what: "How large each part is and which shapes are mixed in. Moving a slider poses the picture only: numbers and files stay those of the fit.",
  groups: { size: "Size of the parts", left: "Left breast", right: "Right breast", trunk: "Trunk" },
  bones: {
    pelvis: "Pelvis",
    lumbar: "Waist",
    lower_thorax: "Lower chest",
    upper_thorax: "Upper chest",
    neck: "Neck",
    shoulder_L: "Shoulder, left",
    shoulder_R: "Shoulder, right",
    upper_arm_L: "Upper arm, left",
    upper_arm_R: "Upper arm, right",
  } as Record<string, string>,
  axes: ["width", "height", "depth"] as const,
  scale: (value: number) => `${Math.round(100 * value)} %`,
  weight: (value: number) => `${value > 0.005 ? "+" : value < -0.005 ? "\u2212" : ""}${Math.abs(value).toFixed(2)}`,
  changed: "Posed by hand: the picture is no longer the fit. Numbers and files are.",
  reset: "Back to the fitted shape",
};
