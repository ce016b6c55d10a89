// The list of keys.

export const help = {
  title: "Keyboard and mouse",
  keys: [
    ["1 – 4", "Go to a step"],
    ["N", "Next landmark"],
    ["Z · Shift+Z", "Undo · redo"],
    ["C", "Take the proposed point"],
    ["Arrows", "Move the chosen landmark along the skin, when the view has the focus (Shift: faster)"],
    ["Esc", "Stop placing"],
    ["F", "View from the front"],
    ["O", "Scan, both, model, beside, swipe"],
    ["D", "Distances in colour"],
    ["Space", "Replay the fit"],
    ["?", "This list"],
  ],
  mouse: [
    ["Click", "Place the wanted landmark, or confirm a dashed one"],
    ["Drag", "Turn the view, or move a placed landmark: a fit then follows at once"],
    ["Right drag", "Move the view"],
    ["Scroll", "Zoom"],
    ["Touch", "One finger turns, two move and zoom, a tap places"],
  ],
};
