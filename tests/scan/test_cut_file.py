"""A file of cuts is what the service answers; whatever else it may be is refused with one sentence."""

import json
from pathlib import Path

import numpy as np
import pytest

from breastrig.core.errors import BadScan
from breastrig.scan.hand_cuts import MOST_CORNERS, MOST_CUTS, read_cuts

PICTURE = np.eye(4).ravel().tolist()
CUT = {"to_picture": PICTURE, "lasso": [[0.0, -9.0], [9.0, -9.0], [9.0, 9.0]]}


def test_the_services_answer_is_read_as_it_is(tmp_path: Path) -> None:
    answer = {"cuts": [CUT, CUT | {"lasso": [[0.0, 0.0], [1, 0], [0.123456789012, 1]]}], "digest": "0123456789abcdef"}
    file = tmp_path / "cuts.json"
    file.write_text(json.dumps(answer), "utf-8")
    assert list(read_cuts(file)) == answer["cuts"] == list(read_cuts(answer))
    assert read_cuts({"cuts": [], "digest": ""}) == ()


@pytest.mark.parametrize(
    "text",
    [
        "",
        "no JSON",
        "[" * 100_000,
        "[]",
        "{}",
        '{"cuts": {}}',
        json.dumps({"cuts": [CUT] * (MOST_CUTS + 1)}),
        json.dumps({"cuts": ["all of it"]}),
        json.dumps({"cuts": [{"lasso": CUT["lasso"]}]}),
        json.dumps({"cuts": [CUT | {"to_picture": PICTURE[:15]}]}),
        json.dumps({"cuts": [CUT | {"to_picture": [1e300, *PICTURE[1:]]}]}),
        json.dumps({"cuts": [CUT | {"to_picture": [float("nan"), *PICTURE[1:]]}]}),
        json.dumps({"cuts": [CUT | {"to_picture": ["x", *PICTURE[1:]]}]}),
        json.dumps({"cuts": [CUT | {"lasso": CUT["lasso"][:2]}]}),
        json.dumps({"cuts": [CUT | {"lasso": [[0.0, 0.0]] * (MOST_CORNERS + 1)}]}),
        json.dumps({"cuts": [CUT | {"lasso": [[0.0, 0.0, 0.0]] * 3}]}),
        json.dumps({"cuts": [CUT | {"lasso": [[0.0, 0.0], [1.0], [2.0, 2.0]]}]}),
        json.dumps({"cuts": [CUT | {"lasso": None}]}),
    ],
)
def test_what_holds_no_cuts_is_refused_with_one_sentence(tmp_path: Path, text: str) -> None:
    file = tmp_path / "cuts.json"
    file.write_text(text, "utf-8")
    with pytest.raises(BadScan, match=r"^[^\n]+a file of cuts is what GET /api/scans/ID/cuts answers\.$"):
        read_cuts(file)


def test_a_file_that_is_not_there_or_far_too_large_is_refused(tmp_path: Path) -> None:
    with pytest.raises(BadScan, match=r"cannot be read \(No such file or directory\); check the name\.$"):
        read_cuts(tmp_path / "none.json")
    large = tmp_path / "large.json"
    large.write_bytes(b" " * 1_000_001)
    with pytest.raises(BadScan, match="larger than 1 MB"):
        read_cuts(large)
