"""Plates, balls and other bodies that are no torso: a proposal and a result, or one sentence; never an error inside.

Whether a result of such a body may be believed is for its verdict to say.
"""

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.bodies import BODIES, any_body, body
from helpers.damage import TIMES, bounded
from helpers.fuzz_table import count
from helpers.refusals import is_sentence
from helpers.scan_files import ply_text
from hypothesis import given
from hypothesis import strategies as st

from breastrig.core.errors import BreastRigError
from breastrig.fitting.hypotheses import scan_orientation
from breastrig.fitting.prepare_scan import prepared
from breastrig.fitting.recipe import load_recipe
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.scan.clean import clean
from breastrig.scan.read import read_scan
from breastrig.use.fit import run_fit
from breastrig.use.steps.settings import FitJob

pytestmark = pytest.mark.long


def file_of(kind: str, seed: int, divisions: int) -> bytes:
    vertices, faces = body(kind, seed, divisions)
    return ply_text(np.round(vertices, 6), faces)


def refused(error: BreastRigError) -> str:
    assert is_sentence(error)
    assert len(str(error)) < 300
    return "refused"


# In parts, crossing itself, without any order, thin; others are in test_verdict_of_fits.py, all in `make fuzz`.
KINDS = sorted(BODIES) if TIMES >= 1 else ["crumpled", "many", "soup", "stick"]


@pytest.mark.slow
@bounded(8)
@given(any_body())
def test_every_body_gets_a_frame_or_a_sentence(what: tuple[str, int, int]) -> None:
    try:
        surface = clean(read_scan(file_of(*what), "ply", "m"))
        rig, recipe = read_rig(default_rig_path()), load_recipe("default")
        frame = scan_orientation(rig, prepared(surface, "auto"), recipe)[0].body_frame()
    except BreastRigError as error:
        count(f"frame of a {what[0]}", refused(error))
        return
    count(f"frame of a {what[0]}", "proposed")
    axes = np.array([frame["up"], frame["front"]])
    np.testing.assert_allclose(axes @ axes.T, np.eye(2), atol=1e-9)
    assert 0.0 <= frame["confidence"] <= 1.0


def numbers(document: Any) -> list[float]:
    """All numbers in a JSON document."""
    if isinstance(document, dict):
        return [number for value in document.values() for number in numbers(value)]
    if isinstance(document, list):
        return [number for value in document for number in numbers(value)]
    return [document] if isinstance(document, int | float) else []


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_every_body_is_fitted_or_refused(kind: str, tmp_path: Path) -> None:
    @bounded(1)
    @given(st.integers(0, 2**32 - 1), st.sampled_from(["auto", "standing", "supine"]), st.booleans())
    def run(seed: int, stance: str, refine: bool) -> None:
        (tmp_path / "scan.ply").write_bytes(file_of(kind, seed, 1))
        job = FitJob(tmp_path / "scan.ply", tmp_path / "out", {}, units="m", stance=stance, refine=refine)
        try:
            *_, last = run_fit(job)
        except BreastRigError as error:
            count(f"fit of a {kind}", refused(error))
            return
        count(f"fit of a {kind}", "fitted")
        assert last.kind == "done"
        result = json.loads((tmp_path / "out" / "result.json").read_text())
        assert result == last.result.document()
        assert all(math.isfinite(number) for number in numbers(result))

    run()
