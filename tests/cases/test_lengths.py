"""A length gives a scan its true size: one file decides about all that is kept of the scan, and taking it away too."""

import numpy as np
import pytest
from helpers.cases import new_case, new_fit, new_scan, note

from breastrig.cases.case_folder import CaseFolder
from breastrig.cases.fits import end_abandoned, fits_of_scan, reason_of
from breastrig.cases.layout import fit_part
from breastrig.cases.lengths import delete_length, get_length, put_length
from breastrig.cases.of_scans import (
    drop_ink,
    get_cuts,
    get_ink,
    get_landmarks,
    get_proposals,
    put_cuts,
    put_ink,
    put_landmarks,
    put_proposals,
)
from breastrig.cases.plans import get_plan, put_plan
from breastrig.cases.removal import move_scan
from breastrig.cases.writing import Changed
from breastrig.core.errors import BadInput, BadLandmarks, Conflict
from breastrig.core.picks import Picks
from breastrig.drawings.plan_schema import PlanLesion, PlanLine, PlanNote
from breastrig.scan.true_size import KEPT

PICKS = Picks(
    {"nipple_L": [70.0, 350.0, 120.0], "navel": [0.1, 0.2, 0.3]}, ("navel",), {}, {"dot": [70.0, 350.0, 20.0]}
)
ENDS, FACTOR = ("nipple_L", "dot"), 1.031
PICTURE = np.arange(16.0).tolist()
CUT = {"to_picture": PICTURE, "lasso": [[0.1, -0.2], [0.4, -0.2], [0.25, 0.12]]}


def items(scan: str) -> list[PlanLine | PlanLesion | PlanNote]:
    return [
        PlanLine(id="line", scan=scan, name="line", points=[[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]),
        PlanLesion(id="lesion", scan=scan, name="lesion", center=[7.0, 8.0, 9.0], radius_mm=6.0),
        PlanNote(id="note", scan=scan, text="here", point=[10.0, 11.0, 12.0]),
        note(scan, "of the whole", "other"),
    ]


def places(case: CaseFolder, version: int | None = None) -> list[float]:
    """All numbers of the plan that are places."""
    shown = {item.id: item for item in get_plan(case, version).document.items}
    line, lesion, here = shown["line"], shown["lesion"], shown["note"]
    assert isinstance(line, PlanLine)
    assert isinstance(lesion, PlanLesion)
    assert isinstance(here, PlanNote)
    assert lesion.radius_mm == 6.0
    return [*np.ravel(line.points).tolist(), *lesion.center, *(here.point or [])]


def test_all_that_is_kept_is_in_the_true_size_and_then_in_the_files_again(case: CaseFolder, scan: str) -> None:
    put_landmarks(case, scan, PICKS)
    put_cuts(case, scan, (CUT,))
    before = put_plan(case, items(scan))
    put_plan(case, [*items(scan), note(scan, "one more", "more")])
    size = put_length(case, scan, ENDS, FACTOR * 100.0)
    assert size.factor == pytest.approx(FACTOR)
    assert case.scan(scan).facts["scale"]["ends"][1] == pytest.approx(
        [FACTOR * value for value in PICKS.marks_mm["dot"]]
    )
    assert case.scan(scan).facts["notes"] == [size.note]
    found = get_landmarks(case, scan)
    for name, at in (PICKS.points_mm | PICKS.marks_mm).items():
        assert (found.points_mm | found.marks_mm)[name] == pytest.approx([FACTOR * value for value in at])
    assert found.certain == PICKS.certain
    [cut] = get_cuts(case, scan)
    there, here = (np.reshape(each["to_picture"], (4, 4)).T for each in (CUT, cut))
    np.testing.assert_allclose(here @ [FACTOR, 2 * FACTOR, 3 * FACTOR, 1.0], there @ [1.0, 2.0, 3.0, 1.0])
    for version in (None, before.document.version):  # what is undone is in the true size too
        assert places(case, version) == pytest.approx([FACTOR * value for value in range(1, 13)])
    with pytest.raises(Changed):
        put_plan(case, items(scan), before.etag)  # of who has seen it in the other size
    delete_length(case, scan)
    assert get_length(case, scan) is None
    assert get_landmarks(case, scan) == PICKS
    assert get_cuts(case, scan) == (CUT,)
    assert places(case) == pytest.approx(list(range(1, 13)))


def test_what_is_kept_in_the_true_size_comes_back_as_it_was_given(case: CaseFolder, scan: str) -> None:
    put_landmarks(case, scan, PICKS)
    put_length(case, scan, ENDS, 97.0)
    put_landmarks(case, scan, PICKS)
    put_cuts(case, scan, (CUT,))
    put_plan(case, items(scan))
    assert get_landmarks(case, scan) == PICKS
    assert get_cuts(case, scan) == (CUT,)
    assert places(case) == list(range(1, 13))
    again = put_length(case, scan, ENDS, 98.0)  # between the places as they are now, measured in the file
    assert (again.measured_mm, again.factor) == (pytest.approx(100.0 / 0.97), pytest.approx(0.98 * 0.97))
    assert get_landmarks(case, scan).points_mm["navel"] == pytest.approx([0.098, 0.196, 0.294])


def test_the_length_goes_with_the_scan_to_another_case(cases, case: CaseFolder, scan: str) -> None:
    new_scan(case, b"another")
    other = new_case(cases)
    new_scan(other)
    put_landmarks(case, scan, PICKS)
    put_plan(case, items(scan))
    put_length(case, scan, ENDS, 100.0 * FACTOR)
    move_scan(case, scan, other)
    assert places(other) == pytest.approx([FACTOR * value for value in range(1, 13)])
    delete_length(other, scan)
    assert places(other) == pytest.approx(list(range(1, 13)))
    assert get_landmarks(other, scan) == PICKS


def test_fits_of_another_size_do_not_count(case: CaseFolder, scan: str) -> None:
    put_landmarks(case, scan, PICKS)
    fit = new_fit(case, scan)
    with pytest.raises(Conflict, match="waits or runs"):
        put_length(case, scan, ENDS, 97.0)
    end_abandoned(case, scan, fit, {"kind": "done", "result": {}})
    put_length(case, scan, ENDS, 97.0)
    [found] = fits_of_scan(case, scan)
    assert found.state == "cancelled"
    assert "got another size" in str(reason_of(case.path / fit_part(scan, fit), found.document, found.last))
    delete_length(case, scan)
    assert [each.state for each in fits_of_scan(case, scan)] == ["done"]


def test_what_was_found_on_the_scan_is_looked_for_again(case: CaseFolder, scan: str) -> None:
    put_landmarks(case, scan, PICKS)
    put_ink(case, scan, {"shapes": [{"name": "a"}, {"name": "b"}]})
    drop_ink(case, scan, {"b": True})
    put_proposals(case, scan, "key", {})
    put_length(case, scan, ENDS, 97.0)
    assert get_ink(case, scan) is None
    put_ink(case, scan, {"shapes": [{"name": "a"}, {"name": "b"}]})
    assert get_ink(case, scan).dropped == ["b"]
    assert get_proposals(case, scan, "key") == {}  # whose key is of the size (service/scans/scan_search.py)


@pytest.mark.parametrize(
    ("start", "end", "mm", "says"),
    [
        ("nipple_L", "nose", 97.0, 'The length ends at "nose", no landmark or mark of this scan; there are: nipple_L,'),
        ("dot", "dot", 97.0, "both are dot"),
        ("nipple_L", "dot", 9.7, "it is 100 mm in the scan, but 9.7 mm were given; check the scan's unit"),
    ],
)
def test_a_length_that_cannot_be_meant_changes_nothing(case: CaseFolder, scan: str, start, end, mm, says: str) -> None:
    put_landmarks(case, scan, PICKS)
    with pytest.raises(BadLandmarks, match=says):
        put_length(case, scan, (start, end), mm)
    assert get_landmarks(case, scan) == PICKS


def test_a_damaged_file_is_said(case: CaseFolder, scan: str) -> None:
    (case.scan_folder(scan) / KEPT).write_text('{"length_mm": 3}')
    with pytest.raises(BadInput, match=r"length\.json of this scan is damaged"):
        case.scan(scan)
