from helpers.mr_image import mr_image

from breastrig.scan.images.skin.skin_of_image import skin_of_image
from breastrig_studies.virtual.magnetic.image_skin import HEADS, found_in, row


def test_a_row_says_what_was_found_and_missed():
    made = mr_image("one side")
    found = found_in(made, skin_of_image(made.image))
    assert found.shown == len(found.nipples) == 1
    assert found.skin.mean() < 0.4
    assert not (found.missed > 3.0).any()
    numbers = row("one side", [found, found])
    assert tuple(numbers) == HEADS
    assert (numbers["image"], numbers["women"]) == ("one side", 2)
    assert (numbers["nipples_seen"], numbers["nipples_shown"]) == (2, 2)
