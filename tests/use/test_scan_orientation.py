"""What the upload finds of a scan is found once: proposals and fits begin with it, and nothing is fitted twice."""

import json
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from helpers.bare_example import write_bare_example
from helpers.example_patient import EXAMPLE
from helpers.toy_rig import toy_rig

import breastrig.fitting.starts.orientation as orientation_module
import breastrig.use.fit as run_fit_module
from breastrig.core.assets import asset_folder
from breastrig.fitting import hypotheses, prepare_scan, propose, solve
from breastrig.fitting.task import FitIterate, FitTask
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.scan.around import background
from breastrig.scan.hand_cuts import HandCut, cut_triangles
from breastrig.scan.read import read_scan
from breastrig.use.fit import run_fit
from breastrig.use.landmarks import ProposeJob, propose_on_file
from breastrig.use.read_upload import UploadJob, read_upload
from breastrig.use.steps.events import Event
from breastrig.use.steps.settings import FitJob
from breastrig_studies.output.rig_files import write_rig

pytestmark = pytest.mark.long

SUPINE = asset_folder("example") / "supine"
PICKS = json.loads((EXAMPLE / "landmarks.json").read_text())["landmarks"]


@pytest.fixture(scope="module")
def bare(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """The example's scans by stance, without colours."""
    folder = tmp_path_factory.mktemp("bare")
    return {stance: write_bare_example(stance, folder / f"{stance}.ply") for stance in ("standing", "supine")}


@pytest.fixture
def calls(monkeypatch: pytest.MonkeyPatch) -> dict[str, int]:
    """How often the costly things are done: whole fits, and searches for front, table and start."""
    count = {"fits": 0, "fronts": 0, "starts": 0}
    of_fit, of_front, of_start = (
        solve.checked_iterates,
        prepare_scan.propose_frame,
        orientation_module.start_from_scan,
    )

    def fitted(task: FitTask, *known_opening: object) -> Iterator[FitIterate]:
        count["fits"] += 1
        return of_fit(task, *known_opening)

    def fronts(*args: object) -> object:
        count["fronts"] += 1
        return of_front(*args)

    def starts(*args: object) -> object:
        count["starts"] += 1
        return of_start(*args)

    for module in (hypotheses, run_fit_module):
        monkeypatch.setattr(module, "checked_iterates", fitted)
    monkeypatch.setattr(propose, "iterates_with_second_start", fitted)
    for module in (prepare_scan, background):
        monkeypatch.setattr(module, "propose_frame", fronts)
    for module in (orientation_module, hypotheses):
        monkeypatch.setattr(module, "start_from_scan", starts)
    return count


def upload(scan: Path, folder: Path, model: Path | None = None) -> dict:
    """The facts as they come back from the database."""
    return json.loads(
        json.dumps(
            read_upload(
                UploadJob(scan, "auto", *(folder / name for name in ("kept", "mesh", "small", "volume")), 10**6, model)
            )
        )
    )


def events_of(scan: Path, out: Path, picks: dict[str, list[float]], **more: object) -> list[Event]:
    return list(run_fit(FitJob(scan, out, picks, **more)))


@pytest.mark.slow
def test_with_stance_auto_the_fit_that_shows_the_stance_is_the_fit(
    calls: dict[str, int], bare: dict[str, Path], tmp_path: Path
) -> None:
    auto = events_of(bare["standing"], tmp_path / "auto", {})
    assert calls["fits"] == 1
    asked = events_of(bare["standing"], tmp_path / "asked", {}, stance="standing")
    assert auto[0].stance == "standing"
    assert "the patient seems to stand" in auto[0].stance_reason
    assert [each.nodes for each in auto[1:-1]] == [each.nodes for each in asked[1:-1]]
    names = ("surface_distance_mm", "landmark_distance_mm", "parameters", "iterations", "stop_reason")
    assert [auto[-1].result.document()[name] for name in names] == [asked[-1].result.document()[name] for name in names]


def test_the_time_that_finding_the_stance_takes_is_time_of_solving(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """A clock that goes on by one at each look shows where the fit's looks are booked."""
    now = iter(range(10**6))
    monkeypatch.setattr("breastrig.core.clock.time.perf_counter", lambda: float(next(now)))
    done = events_of(EXAMPLE / "scan.ply", tmp_path, PICKS)[-1]
    timing = done.result.document()["timing_s"]
    assert set(timing) == {"read", "prepare", "align", "solve", "refine", "total"}
    assert timing["align"] <= 2.0
    assert timing["solve"] > timing["read"] + timing["prepare"] + timing["align"]
    assert timing["read"] + timing["prepare"] + timing["align"] + timing["solve"] <= timing["total"]


@pytest.mark.slow
def test_proposals_and_fits_begin_with_what_the_upload_found(
    calls: dict[str, int], bare: dict[str, Path], tmp_path: Path
) -> None:
    scan = bare["supine"]
    facts = upload(scan, tmp_path)
    unit, known = facts["unit"], facts["orientation"]
    assert facts["stance"]["proposed"] == "supine"
    assert facts["table"] is not None
    assert facts["other_pieces"] == []
    width, height, depth = facts["size_m"]  # in the body's axes, however it lies in the file
    assert 0.49 < width < 0.63
    assert height == pytest.approx(0.53, abs=0.01)
    assert 0.18 < depth < 0.23
    assert calls == {"fits": 0, "fronts": 1, "starts": 1}
    calls.update(fits=0, fronts=0, starts=0)
    proposed = propose_on_file(ProposeJob(scan, "ply", unit, None, known))
    assert calls == {"fits": 1, "fronts": 0, "starts": 0}
    calls.update(fits=0)
    fitted = events_of(scan, tmp_path / "known", {}, orientation=known)
    assert calls == {"fits": 1, "fronts": 0, "starts": 0}
    anew = propose_on_file(ProposeJob(scan, "ply", unit))
    fitted_anew = events_of(scan, tmp_path / "anew", {})
    for name, proposal in proposed.items():
        point, there = proposal.pop("point"), anew[name].pop("point")
        assert point == pytest.approx(there, abs=1e-3), name  # mm
        assert proposal == anew[name]
    first, second = (events[-1].result.document() for events in (fitted, fitted_anew))
    assert first["stance"] == second["stance"] == "supine"
    assert first["stance_reason"] == second["stance_reason"]
    assert first["scan"] == second["scan"]
    assert first["surface_distance_mm"]["mean"] == pytest.approx(second["surface_distance_mm"]["mean"], abs=1e-3)


@pytest.mark.slow
def test_an_upload_is_read_with_the_model_that_is_served_and_another_model_looks_anew(
    calls: dict[str, int], tmp_path: Path
) -> None:
    write_rig(toy_rig(), tmp_path)
    model = tmp_path / "toy.glb"
    facts = upload(EXAMPLE / "scan.ply", tmp_path, model)
    assert facts["orientation"]["model_sha256"] == read_rig(model).sha256
    torso = upload(EXAMPLE / "scan.ply", tmp_path)
    assert torso["orientation"]["model_sha256"] == read_rig(default_rig_path()).sha256
    assert facts["frame"] != torso["frame"]
    calls.update(fits=0, fronts=0, starts=0)
    propose_on_file(ProposeJob(EXAMPLE / "scan.ply", "ply", "m", None, facts["orientation"]))
    assert calls["fronts"] == calls["starts"] == 1


@pytest.mark.slow
def test_what_was_cut_as_table_or_by_hand_is_in_the_result(tmp_path: Path) -> None:
    """A lying patient's table goes, and result.json says how much of the scan that was."""
    picks = json.loads((SUPINE / "landmarks.json").read_text())["landmarks"]
    result = events_of(SUPINE / "scan.ply", tmp_path / "auto", picks)[-1].result.document()
    cut = result["scan"]["table_triangles"]
    assert 0.3 < cut / result["scan"]["triangles"] < 0.45
    assert f"{cut} triangles of the table under the patient were left out." in result["notes"]
    scan = read_scan(SUPINE / "scan.ply", "ply", "auto", texture=False)
    lasso = [[-0.06, -1.0], [0.1, -1.0], [0.1, 1.0], [-0.06, 1.0]]
    corner = {"to_picture": np.eye(4).ravel().tolist(), "lasso": lasso}
    cut = int(np.count_nonzero(cut_triangles(scan.vertices, scan.faces, [HandCut.of(corner)])))
    assert cut > 200
    standing = events_of(SUPINE / "scan.ply", tmp_path / "standing", picks, stance="standing", cuts=(corner,))
    result = standing[-1].result.document()
    assert result["scan"]["table_triangles"] == 0
    assert result["scan"]["cut_by_hand_triangles"] == cut
    assert result["scan"]["triangles"] == len(scan.faces)
    assert f"{cut:,} triangles were cut away by hand." in result["notes"]
