"""Numbers that separate features from similar structures; each has its reason beside it in features.toml."""

from functools import lru_cache

from breastrig.core.settings_file import Positive, SettingsPart, packaged


class AreolaLimits(SettingsPart):
    """Limits of colour/features/areola.py and nipple.py."""

    lightness: Positive  # weights of darker and redder in the search
    redness: Positive
    radii: tuple[Positive, ...]  # m, of the discs
    looked_at: int  # candidates that are measured
    smallest: Positive  # m, radius
    largest: Positive
    least_contrast: Positive  # Lab
    least_clearness: Positive  # standard deviations
    most_scatter: Positive  # of the radius
    least_border: Positive  # share of rays
    least_redness: Positive  # Lab, of a* over the skin around; shade is dark and not red
    sure_clearness: Positive  # with less redness than that it must be this clear,
    sure_border: Positive  # have this much of a border
    sure_redness: Positive  # and some redness still, as on dark skin; what covers a nipple has less than the skin
    spot: Positive  # m, radius of a nipple
    spot_weight: Positive  # of its colour against that of the areola, in the logarithm of a chance
    bump_weight: Positive  # likewise of its height
    error_scale: Positive  # times the standard deviation of the chances
    off_centre: Positive  # m, of a nipple from the middle of its areola, on each axis
    least_spread: Positive  # m; the form is never trusted to be nearer than this, root mean square
    farthest: Positive  # times the spread; beyond, the form rules it out
    least_apart: Positive  # m, of the left nipple from the right one towards the body's left
    floor: Positive  # m, error of the nipple's place that no scatter shows, on each axis of the skin
    radius_floor: Positive  # m, likewise of the radius


class NavelLimits(SettingsPart):
    """Limits of colour/features/navel.py."""

    lightness: Positive  # weights of darker and redder
    redness: Positive
    spot: Positive  # m, radius of the spot of colour
    dent: Positive  # m, radius of the dent
    most: Positive  # standard deviations; more says no more
    weight: Positive  # of one standard deviation in the logarithm of a chance
    aside: Positive  # m, error of the form's midline
    least_spread: Positive  # m; the form is never trusted to know the height better
    one_place: Positive  # m, radius of what counts as the same place
    least_chance: Positive  # of that place, against all others
    least_spot: Positive  # standard deviations of colour
    floor: Positive  # m, error on each axis of the skin that the chances do not show


class CrossLimits(SettingsPart):
    """Limits of colour/features/crosses.py."""

    around: Positive  # m, how far around a landmark ink is looked for
    aside: Positive  # m, of a cross from the form's midline
    farthest: Positive  # times the spread; beyond, a cross marks something else
    one_place: Positive  # m; crosses farther apart leave open which is meant
    between: Positive  # m, root mean square, of the middle between two of them
    error: Positive  # m, root mean square, of a cross that was drawn on a landmark


class Features(SettingsPart):
    """The contents of features.toml."""

    areola: AreolaLimits
    navel: NavelLimits
    crosses: CrossLimits


@lru_cache(maxsize=1)
def features() -> Features:
    """The package's own settings (features.toml), read once."""
    return packaged(Features, "breastrig.colour.features", "features.toml")
