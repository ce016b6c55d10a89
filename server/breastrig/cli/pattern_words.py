"""What patterns.pattern_help says, so that `breastrig fit --help` need not wait for the classes behind it.

A test compares both.
"""

PATTERN_WORDS = (
    "reduction has side: the patient's side (if not said both); areola_mm: diameter of the new areola; 40 to 45 is "
    "usual (if not said 42.0); limb_mm: vertical limbs; 45 to 60 is usual; if not said 50, less over a near fold; "
    "limb_angle_deg: between the limbs; wider takes more skin (if not said 60.0); opening_deg: of the keyhole, seen"
    " from the new nipple (if not said 90.0); nipple_above_fold_mm: new nipple over the fold's height (if not said "
    "0.0). tumour has side: the patient's side; clock: hour as read by an observer who faces her: 3 is towards her "
    "left on both breasts; distance_mm: from the nipple along the skin; a breast is not longer; radius_mm: of the "
    "circle along the skin; margin included, T3 starts at 25. tumour_at has x_mm: of the centre in the scan's "
    "frame, whatever its unit; y_mm: likewise; z_mm: likewise; radius_mm: of the circle along the skin; margin "
    "included, T3 starts at 25."
)
