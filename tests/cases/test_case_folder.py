"""A case is made whole, opened, and its documents come back as they were written."""

import os
import stat
from pathlib import Path

import pytest
from helpers.cases import FACTS, new_case, new_scan, say

from breastrig.cases import layout
from breastrig.cases.case_folder import COMING, CaseFolder
from breastrig.cases.documents import AnswersDocument, ScanDocument
from breastrig.cases.of_scans import (
    drop_ink,
    etag_of_scan,
    get_answers,
    get_cuts,
    get_ink,
    get_landmarks,
    get_proposals,
    put_cuts,
    put_ink,
    put_landmarks,
    put_proposals,
)
from breastrig.cases.writing import PART, Changed
from breastrig.core.errors import BadDrawing, BadInput, Conflict, NeedsYes, NotFound
from breastrig.core.picks import Picks


def test_a_new_case_has_a_code_and_no_scans(tmp_path: Path) -> None:
    named = CaseFolder.create(tmp_path / "one", "  K7M   4QX ")
    assert named.document().code == "K7M 4QX"
    unnamed = CaseFolder.create(tmp_path / "some" / "where" / "two")
    assert len(unnamed.document().code) == 7
    assert CaseFolder(unnamed.path).scans() == []
    assert sorted(path.name for path in tmp_path.iterdir()) == ["one", "some"]


def test_what_is_there_already_is_no_place_for_a_case(tmp_path: Path) -> None:
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "letter").write_text("text")
    for name in ("mine", "mine/letter"):
        with pytest.raises(BadInput, match="is there already"):
            CaseFolder.create(tmp_path / name)
    assert [path.name for path in tmp_path.rglob("*")] == ["mine", "letter"]


def test_a_folder_that_is_no_case_is_none(tmp_path: Path) -> None:
    for place in (tmp_path, tmp_path / "nothing"):
        with pytest.raises(NotFound, match="There is no case at"):
            CaseFolder(place)


def test_only_the_owner_can_read(case: CaseFolder, scan: str) -> None:
    before = os.umask(0)
    try:
        put_landmarks(case, scan, Picks({"nipple_L": [1.0, 2.0, 3.0]}))
        new_scan(case)
    finally:
        os.umask(before)
    assert {stat.S_IMODE(path.stat().st_mode) & 0o077 for path in case.path.rglob("*")} == {0}


def test_a_code_is_one_line_of_limited_length(case: CaseFolder) -> None:
    assert case.rename(" A  1").code == case.document().code == "A 1"
    assert len(case.rename("").code) == 7
    with pytest.raises(BadInput, match="60 characters"):
        case.rename("x" * 61)


def test_scans_come_back_in_the_order_of_their_arrival(case: CaseFolder) -> None:
    for day in (2, 1, 3):
        with case.incoming() as made:
            (made / layout.STORED).write_bytes(b"skin")
            case.add_scan(made, ScanDocument(created_at=f"2026-01-0{day}", sha256=f"{day}", facts=FACTS))
    assert [one.document.sha256 for one in case.scans()] == ["1", "2", "3"]
    with pytest.raises(NotFound):
        case.scan("../../other")


def test_the_same_file_again_is_asked_about(case: CaseFolder) -> None:
    document = ScanDocument(created_at="2026-01-01", sha256="ab", facts=FACTS)
    for again in (False, True):
        with case.incoming() as made:
            case.add_scan(made, document, again=again)
    with pytest.raises(NeedsYes, match="the same file"), case.incoming() as made:
        case.add_scan(made, document)
    assert len(case.scans()) == 2
    left = [path for path in case.around.incoming.iterdir() if path.name.startswith(COMING)]
    assert left == []


def test_landmarks_cuts_and_answers_are_replaced_by_who_has_seen_them(case: CaseFolder, scan: str) -> None:
    picks = Picks({"nipple_L": [1.5, 2.0, 3.0]}, ("nipple_L",), {})
    first = put_landmarks(case, scan, picks, "0")
    assert get_landmarks(case, scan) == picks
    with pytest.raises(Changed) as refused:
        put_landmarks(case, scan, Picks({}), "0")
    assert refused.value.etag == first == etag_of_scan(case, scan, layout.LANDMARKS)
    assert put_landmarks(case, scan, Picks({}), first) == etag_of_scan(case, scan, layout.LANDMARKS) == "0"
    assert get_landmarks(case, scan) == Picks({})
    cuts = ({"to_picture": [1.0] * 16, "lasso": [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]},)
    assert get_cuts(case, scan) == ()
    put_cuts(case, scan, cuts, "0")
    assert get_cuts(case, scan) == cuts
    assert get_answers(case, scan) == AnswersDocument()
    say(case, scan, side="L", visit="before")
    assert get_answers(case, scan).side == "L"


def test_landmarks_that_were_edited_by_hand_say_their_unit(case: CaseFolder, scan: str) -> None:
    (case.scan_folder(scan) / layout.LANDMARKS).write_text(
        '{"schema": "breastrig/landmarks@1", "unit": "cm", "landmarks": {"umbilicus": [1, 2, 3]}}'
    )
    assert get_landmarks(case, scan).points_mm == {"umbilicus": [10.0, 20.0, 30.0]}


def test_ink_keeps_what_was_dropped_when_it_is_looked_for_again(case: CaseFolder, scan: str) -> None:
    assert get_ink(case, scan) is None
    with pytest.raises(Conflict):
        drop_ink(case, scan, {"violet-1": True})
    drawing = {"schema": "breastrig/drawing@1", "unit": "mm", "name": "ink", "shapes": [{"name": "violet-1"}]}
    put_ink(case, scan, drawing)
    with pytest.raises(BadDrawing, match="nothing"):
        drop_ink(case, scan, {"nothing": True})
    assert drop_ink(case, scan, {"violet-1": True}).dropped == ["violet-1"]
    put_ink(case, scan, drawing)
    found = get_ink(case, scan)
    assert found is not None
    assert found.dropped == ["violet-1"]
    assert found.model_dump()["name"] == "ink"
    assert drop_ink(case, scan, {"violet-1": False}).dropped == []


def test_proposals_are_of_one_model(case: CaseFolder, scan: str) -> None:
    assert get_proposals(case, scan, "model") is None
    put_proposals(case, scan, "model", {"nipple_L": {"point": [1, 2, 3]}})
    assert get_proposals(case, scan, "model") == {"nipple_L": {"point": [1, 2, 3]}}
    assert get_proposals(case, scan, "other") is None


def test_nothing_is_written_for_a_scan_that_is_not_here(case: CaseFolder) -> None:
    for scan in (layout.new_id(), "..", "a/b", ""):
        with pytest.raises(NotFound):
            put_landmarks(case, scan, Picks({}))
        with pytest.raises(NotFound):
            get_landmarks(case, scan)
    assert not list(case.path.rglob(layout.LANDMARKS))


def test_a_damaged_document_is_one_sentence(case: CaseFolder, scan: str) -> None:
    for content in (b"", b"{", b"[]", b'{"schema": "other@1"}', b"[" * 100_000):
        (case.scan_folder(scan) / layout.SCAN).write_bytes(content)
        with pytest.raises(BadInput, match=r"scan\.json of this case is damaged") as error:
            case.scan(scan)
        assert "\n" not in str(error.value)


def test_the_stamp_grows_with_each_change_whatever_the_clock(case: CaseFolder, scan: str, monkeypatch) -> None:
    stamps = [case.stamp]
    monkeypatch.setattr("breastrig.cases.writing.time.time_ns", lambda: 1_000)  # the clock was set back
    for k in range(5):
        put_landmarks(case, scan, Picks({"nipple_L": [float(k), 0.0, 0.0]}))
        stamps.append(case.stamp)
    assert stamps == sorted(set(stamps))


def test_what_killed_writers_have_left_goes_with_the_next_writer(case: CaseFolder, scan: str) -> None:
    (case.path / f"{PART}abc").write_text("half a plan")
    put_landmarks(case, scan, Picks({}))
    assert list(case.path.glob(f"{PART}*")) == []


def test_a_case_that_was_deleted_is_not_made_again_by_who_waited(case: CaseFolder, scan: str) -> None:
    case.path.rename(case.path.with_name("away"))
    with pytest.raises(NotFound):
        put_landmarks(case, scan, Picks({}))
    with pytest.raises(NotFound):
        _ = case.stamp
    assert not case.path.exists()


def test_two_cases_do_not_disturb_each_other(cases: Path) -> None:
    one, other = new_case(cases), new_case(cases)
    with one.writing():
        other.rename("B")
    assert other.document().code == "B"
