from pathlib import Path

import pytest

from breastrig.batch.manifest import BadManifest, BatchRow, read_manifest
from breastrig.core.assets import asset_folder
from breastrig.core.picks import Length
from breastrig.rig.model import Rig
from breastrig.scan.volumes.answers import VolumeAnswers
from breastrig.use.steps.settings import FitSettings

EXAMPLE = asset_folder("example") / "standing"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "a.ply").write_bytes(b"ply")
    (tmp_path / "b.ply").write_bytes(b"ply")
    (tmp_path / "picks.json").write_bytes((EXAMPLE / "landmarks.json").read_bytes())
    (tmp_path / "picks.csv").write_text("nippel_L,1,2,3\n")
    return tmp_path


def rows(folder: Path, rig: Rig, *lines: str, encoding: str = "utf-8") -> tuple[BatchRow, ...]:
    (folder / "m.csv").write_text("\n".join(lines) + "\n", encoding)
    return read_manifest(folder / "m.csv", rig, folder / "out")


def faults(folder: Path, rig: Rig, *lines: str) -> list[str]:
    with pytest.raises(BadManifest) as found:
        rows(folder, rig, *lines)
    return found.value.faults


def test_every_column_is_read_and_paths_are_relative_to_the_manifest(folder: Path, rig: Rig) -> None:
    first, second = rows(
        folder,
        rig,
        "scan,landmarks,name,units,stance,preset,drawing,tumour,refine",
        'a.ply,picks.json,Ada,mm,supine,paper,anatomy,"L:10,45,12 R:3,30,8",no',
        "b.ply,,,,,,none,,",
    )
    assert first == BatchRow(
        name="Ada",
        scan=folder / "a.ply",
        landmarks=folder / "picks.json",
        units="mm",
        settings=FitSettings(
            stance="supine", preset="paper", drawing="anatomy+tumour:L,10,45,12+tumour:R,3,30,8", refine=False
        ),
    )
    assert second == BatchRow("0002-b", folder / "b.ply", None, "auto", FitSettings(drawing=None))


def test_what_a_row_does_not_say_is_as_in_fit(folder: Path, rig: Rig) -> None:
    (row,) = rows(folder, rig, "scan", "a.ply")
    assert row == BatchRow("0001-a", folder / "a.ply", None, "auto", FitSettings(drawing="lumpectomy"))


@pytest.mark.parametrize("split", [";", "\t"])
def test_tables_of_other_programs_are_read(split: str, folder: Path, rig: Rig) -> None:
    found = rows(folder, rig, f"Scan{split}Name", f"a.ply{split}Zoë", "", f"b.ply{split}B", encoding="utf-8-sig")
    assert [row.name for row in found] == ["Zoë", "B"]


def test_each_wrong_row_is_one_sentence_with_its_line(folder: Path, rig: Rig) -> None:
    (folder / "certain.json").write_text('{"landmarks": {"nipple_L": [1, 2, 3]}, "certain": ["nipple_R"]}')
    found = faults(
        folder,
        rig,
        "scan,name,landmarks,units,stance,preset,drawing,tumour,refine",
        "a.ply,one",
        "missing.ply,two",
        "b.ply,ONE",
        "",
        ",five",
        "a.ply,six,missing.json",
        "a.ply,seven,picks.csv",
        "a.ply,eight,,furlong",
        "a.ply,nine,,,sitting",
        "a.ply,ten,,,,fast",
        "a.ply,eleven,,,,,flower",
        "a.ply,twelve,,,,,,L:10",
        "a.ply,thirteen,,,,,,,perhaps",
        "a.ply,fourteen,,,,own.toml",
        "a.ply,fifteen,certain.json",
    )
    words = (
        (3, "There is no scan missing.ply"),
        (4, 'The name "ONE" is also that of line 2'),
        (6, "There is no scan in this row"),
        (7, "There is no landmark file missing.json"),
        (8, 'Is "nippel_L" the landmark nipple_L?'),
        (9, '"furlong" is not a unit; known are: auto, m'),
        (10, '"sitting" is not a stance; known are: auto, standing, supine'),
        (11, '"fast" is not a preset'),
        (12, '"flower" is not a drawing of this model'),
        (13, '"L:10" is not a tumour'),
        (14, '"perhaps" is not a value of refine'),
        (15, "There is no preset own.toml"),
        (16, '"certain" names nipple_R, which is not among these landmarks'),
    )
    assert len(found) == len(words)
    for fault, (line, text) in zip(found, words, strict=True):
        assert fault.startswith(f"m.csv, line {line}: {text}")
        assert fault.endswith(".")


@pytest.mark.parametrize(
    "name",
    ["../out2", "/tmp/x", "a/b", "a\\b", ".", "..", ".hidden", "a.", "batch.csv", "x" * 300, "é" * 101, "bell\a"],
)
def test_a_name_that_leaves_the_folder_or_is_no_plain_name_is_refused(name: str, folder: Path, rig: Rig) -> None:
    (fault,) = faults(folder, rig, "scan,name", f"a.ply,{name}")
    assert "cannot be the name of a folder here" in fault


def test_a_folder_that_no_batch_has_made_is_not_replaced(folder: Path, rig: Rig) -> None:
    (folder / "out" / "mine").mkdir(parents=True)
    (folder / "out" / "linked").symlink_to(folder)
    (folder / "out" / "done").mkdir()
    (folder / "out" / "done" / "inputs.json").write_text("{}")
    found = faults(folder, rig, "scan,name", "a.ply,mine", "a.ply,linked", "a.ply,done", "a.ply,new")
    assert [fault.split(":")[0] for fault in found] == ["m.csv, line 2", "m.csv, line 3"]
    assert "is no result of a batch" in found[0]


@pytest.mark.parametrize(
    ("lines", "words"),
    [
        (["scan,colour", "a.ply,red"], '"colour" is not a column; known are: scan, landmarks'),
        (["scan,name,scan", "a.ply,x,b.ply"], "The column scan is there twice"),
        (["name", "a"], "has no column scan"),
        (["a.ply", "b.ply"], '"a.ply" is not a column'),
        (["scan,name"], "m.csv has no rows"),
        ([""], "has no column scan"),
        (["scan,name", "a.ply,x,y"], "line 2: 3 values for 2 columns"),
        (["scan,name", 'a.ply,"x'], "line 2: This is no table"),
    ],
)
def test_a_table_of_another_kind_is_one_sentence(lines: list[str], words: str, folder: Path, rig: Rig) -> None:
    (fault,) = faults(folder, rig, *lines)
    assert words in fault


def test_a_file_that_is_no_text_or_not_there_is_one_sentence(folder: Path, rig: Rig) -> None:
    (folder / "m.csv").write_bytes(b"\xff\xfe\x00scan")
    with pytest.raises(BadManifest, match="no text in UTF-8"):
        read_manifest(folder / "m.csv", rig, folder)
    with pytest.raises(BadManifest, match="cannot be read"):
        read_manifest(folder / "none.csv", rig, folder)


def test_a_label_maps_answers_are_columns(folder: Path, rig: Rig) -> None:
    first, second = rows(folder, rig, "scan,frame,segments", "a.ply,ras,2=lesion 3=unused", "b.ply,,")
    assert first.answers == VolumeAnswers("RAS", {2: "lesion", 3: "unused"})
    assert not second.answers
    assert "This is no frame" in faults(folder, rig, "scan,frame", "a.ply,up")[0]
    assert "can be lesion, tissue or unused" in faults(folder, rig, "scan,segments", "a.ply,2=skin")[0]


def test_a_length_is_read_and_checked(folder: Path, rig: Rig) -> None:
    head = "scan,landmarks,length"
    (row,) = rows(folder, rig, head, "a.ply,picks.json,nipple_L | suprasternal_notch | 187")
    assert row.settings.length == Length("nipple_L", "suprasternal_notch", 187.0)
    for text, says in (
        ("picks.json,nipple_L|187", "A length is two names and millimetres"),
        ("picks.json,nipple_L|xiphoid|-3", "must be a number of millimetres above 0"),
        (",nipple_L|xiphoid|187", "this row names no landmark file"),
    ):
        with pytest.raises(BadManifest, match=says):
            rows(folder, rig, head, f"a.ply,{text}")
