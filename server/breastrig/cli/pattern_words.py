"""What patterns.pattern_help says, so that `breastrig fit --help` need not wait for the classes behind it.

A test compares both.
"""

PATTERN_WORDS = (
    "reduction has side: the patient's side (if not said both); areola_mm: diameter of the new areola; 40 to 45 "
    "is usual (if not said 42.0); limb_mm: vertical limbs; 45 to 60 is usual; if not said 50, less over a near "
    "fold; limb_angle_deg: between the limbs; wider takes more skin (if not said 60.0); opening_deg: of the "
    "keyhole, seen from the new nipple (if not said 90.0); nipple_above_fold_mm: new nipple over the fold's "
    "height (if not said 0.0); nipple_outward_mm: new nipple outwards of the meridian, along the skin (if not "
    "said 0.0); fold_below_mm: new fold under her own, along the skin (if not said 0.0). vertical has side: the "
    "patient's side (if not said both); areola_mm: diameter of the new areola; 40 to 45 is usual (if not said "
    "42.0); width_mm: between the limbs at half their way; what is pinched (if not said 60.0); above_fold_mm: "
    "where the limbs meet; 20 to 40 is usual (if not said 25.0); nipple_above_fold_mm: new nipple over the "
    "fold's height (if not said 0.0); nipple_outward_mm: new nipple outwards of the meridian, along the skin "
    "(if not said 0.0). periareolar has side: the patient's side (if not said both); areola_mm: diameter of the "
    "new areola; 40 to 45 is usual (if not said 42.0); outer_mm: width of the outer ring; over 100 scars widen "
    "(if not said 80.0); lift_mm: of the nipple: the outer ring reaches so much higher (if not said 15.0). "
    "ellipse has side: the patient's side (if not said both); length_mm: of the long axis along the skin, "
    "through the nipple (if not said 140.0); width_mm: across it; what can be closed again (if not said 70.0); "
    "axis_deg: of the long axis over the horizontal, rising towards the armpit; 0 lies across, 90 stands (if "
    "not said 20.0). tumour has side: the patient's side; clock: hour as read by an observer who faces her: 3 "
    "is towards her left on both breasts; distance_mm: from the nipple along the skin; a breast is not longer; "
    "radius_mm: of the circle along the skin; margin included, T3 starts at 25. tumour_at has x_mm: of the "
    "centre in the scan's frame, whatever its unit; y_mm: likewise; z_mm: likewise; radius_mm: of the circle "
    "along the skin; margin included, T3 starts at 25."
)
