"""Decides which landmarks are proposed on a scan: one rule for the service, programs and the command line."""

FARTHEST = 0.1  # m, of the radius: a hand's breadth away any landmark of the trunk may be meant
NO_SKIN = 0.03  # m; a fold that a breast covers has skin within 10 mm, a navel below an MRI's end none within 100 mm


def why_not_proposed(to_skin: float, error: float | None) -> str | None:
    """The sentence for a landmark that is not proposed; None for one that is.

    `to_skin` is how far (m) the scan's skin is from where it is expected, `error` the radius (m) that holds the true
    place with 90 %.
    """
    if to_skin > NO_SKIN:
        return "The scan shows no skin where it is expected."
    if error is not None and error > FARTHEST:
        return f"It may lie more than {1e3 * FARTHEST:.0f} mm from where it is expected."
    return None
