import csv
from pathlib import Path

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


def test_the_documented_table_is_the_one_that_the_study_wrote(repository: Path) -> None:
    page = (repository / "docs/explanation/accuracy.md").read_text("utf-8").splitlines()
    with (repository / "docs/explanation/accuracy/images.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert tuple(rows[0]) == HEADS
    for each in rows:
        shown = [each[name] for name in HEADS[2:7]]
        nipples = f"{each['nipples_mean_mm']} / {each['nipples_worst_mm']}" if each["nipples_mean_mm"] else "–"
        seen = f"{each['nipples_seen']} of {each['nipples_shown']}"
        assert f"|{'|'.join([each['image'], *shown, nipples, seen])}|" in page
