// The list of keys.

export const help = {
  title: "Keyboard and mouse",
  keys: [
    ["1 – 4", "Body, set points myself, plan, hand over"],
    ["N", "Next landmark"],
    ["Arrows", "On the body: move the cross of the wanted landmark, or nudge a placed one along the skin; else turn the body (Shift: faster)"],
    ["Enter", "On the body: place the landmark under the cross"],
    ["+ · −", "On the body: zoom"],
    ["C", "Take the proposed point"],
    ["Z · Shift+Z", "Undo · redo"],
    ["Esc", "Stop placing"],
    ["P · E · T · M", "In the plan: pen, points of a line, tumour, tape measure; Enter ends a line or the tape, Delete takes away a point or a line"],
    ["Tab, arrows", "In the plan: from handle to handle of a pattern; arrows move it by 1 mm (Shift: 5 mm)"],
    ["Slices", "Arrows move the cross by 1 mm (Shift: 5 mm), Page Up and Page Down go through, + and − zoom, Enter enlarges one and back, Esc closes"],
    ["Image in slices", "Comma and full stop darken and lighten, with Shift give and take contrast, 0 shows it as it came; or drag with the right button"],
    ["Lasso", "In the body's details: draw around what is to be cut away; Z brings it back, Esc puts the lasso down"],
    ["F", "View from the front"],
    ["O", "Scan, both, model"],
    ["D", "Distances in colour"],
    ["Space", "Replay the fit"],
    ["?", "This list"],
  ],
  mouse: [
    ["Click", "Place the wanted landmark, or confirm a dashed one"],
    ["Drag", "Turn the view, or move a placed landmark: the model follows, and a fit when it is let go"],
    ["Right drag", "Move the view"],
    ["Scroll", "Zoom; in slices go through, with Ctrl zoom"],
    ["Double click", "In slices: one to the whole stage, and back; two fingers zoom"],
    ["Pen", "Once a stylus was seen it draws, and fingers turn, move and zoom; the hand that holds it does nothing"],
    ["Touch", "One finger turns, two move and zoom, a tap places; held still, a cross above the finger places when you let go"],
  ],
};
