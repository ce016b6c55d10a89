"""The whole way with the real registration and the packaged model: upload, landmarks, fit, events, files."""

import hashlib
import json
from collections.abc import Iterator

import numpy as np
import pytest
from flask.testing import FlaskClient
from helpers.problems import problem
from helpers.remembered_fits import run_fit_once
from helpers.waiting import ended, until

from breastrig.api.app import create_app
from breastrig.api.config import Config
from breastrig.core.assets import asset_folder
from breastrig.execution.limits import FitLimits
from breastrig.gltf.pose_nodes import posed_by_nodes
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.skinning import pose
from breastrig.service.service import Service
from breastrig.storage.documents.fits import get_fit
from breastrig.storage.storage import Storage

pytestmark = pytest.mark.long


@pytest.fixture(scope="module")
def real(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Service, FlaskClient]]:
    service = Service(
        Storage(tmp_path_factory.mktemp("real")), runner=run_fit_once, fits=FitLimits(workers=1, grace_s=0.1)
    )
    with service.started():
        yield service, create_app(Config(), service).test_client()


def fitted(service: Service, client: FlaskClient, scan: dict, landmarks: dict, **wishes: object) -> dict:
    """result.json of a fit that is checked on its way."""
    assert client.put(scan["links"]["landmarks"], json={"landmarks": landmarks}).status_code == 200
    links = client.post("/api/fits", json={"scan": scan["id"], "drawing": "lumpectomy", **wishes}).json["links"]
    fit = ended(service, links["self"].rsplit("/", 1)[1])
    assert fit.state == "done", fit.reason
    events = client.get(links["events"] + ".json").json["events"]
    kinds = [one["event"]["kind"] for one in events]
    assert kinds == ["started", *["iterated"] * fit.iterations, "done"]
    assert [one["event"]["iteration"] for one in events[1:-1]] == list(range(fit.iterations))
    last = client.get(f"{links['self']}/iterations/{fit.iterations - 1}.gltf")
    assert last.status_code == 200
    received = {node["name"]: node for node in events[-2]["event"]["nodes"]}
    for node in json.loads(last.data)["nodes"]:
        for key in ("translation", "rotation", "scale", "weights"):
            if key in received.get(node.get("name"), {}) and key in node:
                wanted = received[node["name"]][key]
                assert np.allclose(node[key][: len(wanted)], wanted, atol=2e-6)
                assert node[key][len(wanted) :] in ([], [1.0]), "the layer of smooth modes is on"
    for name in ("fitted_glb", "fitted_ply", "drawing"):
        with client.get(links[name]) as answer:
            assert answer.status_code == 200
            assert len(answer.data) > 1000
    with client.get(links["result"]) as answer:
        result = answer.json
    with client.get(links["distances"]) as answer:
        each_mm = np.frombuffer(answer.data, "<f4")
    reported = result["surface_distance_mm"]
    assert len(each_mm) == result["model"]["vertices"]
    assert np.isfinite(each_mm).mean() == pytest.approx(reported["coverage"], abs=1e-4)
    assert np.nanmean(np.abs(each_mm)) == pytest.approx(reported["mean"], abs=1e-3)
    assert np.nanmax(np.abs(each_mm)) == pytest.approx(reported["max"], abs=1e-3)
    assert result.pop("fields")  # hashes of what is written there
    assert events[-1]["event"]["result"] == result
    return result


def nothing_left(service: Service) -> bool:
    """Whether no file of a patient is left: the fits' models, which are nobody's, and the audit log stay."""
    root = service.storage.root
    return not [file for file in root.glob("*/*") if file.parent not in (root / "models", root / "audit")]


def test_the_packaged_examples_are_all_there(real: tuple[Service, FlaskClient]) -> None:
    found = [(one["name"], one["stance"]) for one in real[1].get("/api/examples").json["examples"]]
    assert found == [("marked", "standing"), ("standing", "standing"), ("supine", "supine"), ("mri", "prone")]


@pytest.mark.slow
def test_the_packaged_example_is_fitted(real: tuple[Service, FlaskClient]) -> None:
    service, client = real
    opened = client.post("/api/examples/supine")
    assert opened.status_code == 201, opened.json
    scan = opened.json
    assert scan["stance"]["proposed"] == "supine"
    picked = scan["example_landmarks"]["landmarks"]
    until(lambda: client.get(scan["links"]["proposed"]).status_code != 202, "the proposed landmarks")
    proposed = client.get(scan["links"]["proposed"])
    assert proposed.status_code == 200
    off = {k: np.linalg.norm(np.subtract(v["point"], picked[k])) for k, v in proposed.json["landmarks"].items()}
    assert set(off) == set(picked)
    assert np.mean(list(off.values())) < 20.0
    result = fitted(service, client, scan, picked)
    assert result["stance"] == "supine"
    file = asset_folder("example") / "supine" / "scan.ply"
    assert result["scan"]["sha256"] == hashlib.sha256(file.read_bytes()).hexdigest()  # the user's own file
    assert result["refined"]
    assert result["surface_distance_mm"]["mean"] < 0.5
    assert result["model_alone"]["surface_distance_mm"]["mean"] < 2.4
    assert result["landmark_distance_mm"]["mean"] < 6.0
    row = client.get(scan["links"]["patient"]).json["scans"][0]
    assert (row["fit"]["state"], row["fit"]["verdict"], row["stance"]) == ("done", result["verdict"]["level"], "supine")
    plain = fitted(service, client, scan, picked, refine=False)
    assert not plain["refined"]
    distances = ("surface_distance_mm", "scan_to_model_mm", "landmark_distance_mm")
    for found in (plain, plain["model_alone"]):
        assert {name: found[name] for name in distances} == result["model_alone"]
    assert client.delete(scan["links"]["self"]).status_code == 204
    assert nothing_left(service)


@pytest.mark.slow
def test_what_was_only_agreed_to_keeps_its_error_and_is_counted(real: tuple[Service, FlaskClient]) -> None:
    service, client = real
    scan = client.post("/api/examples/supine").json
    until(lambda: client.get(scan["links"]["proposed"]).status_code != 202, "the proposed landmarks")
    proposed = client.get(scan["links"]["proposed"]).json["landmarks"]
    result = fitted(service, client, scan, {name: each["point"] for name, each in proposed.items()})
    client.delete(scan["links"]["self"])
    assert sorted(result["landmarks_agreed"]) == sorted(proposed)
    assert sum("only agreed to" in reason for reason in result["verdict"]["reasons"]) == 1
    assert min(result["landmark_uncertainty_mm"].values()) > 4.0
    left, right = (result["arm_angles_deg"][side] for side in "LR")
    assert 0 < left < 90
    assert right == pytest.approx(left, abs=15)


@pytest.mark.slow
def test_a_fit_goes_on_from_an_earlier_one_of_its_scan(real: tuple[Service, FlaskClient]) -> None:
    service, client = real
    scan = client.post("/api/examples/supine").json
    picked = scan["example_landmarks"]["landmarks"]
    body = {"scan": scan["id"], "landmarks": picked}
    first = client.post("/api/fits", json=body).json
    assert ended(service, first["id"]).state == "done"
    assert client.get(first["links"]["self"]).json["drawing"] is None
    with client.get(first["links"]["drawing"]) as drawing, client.get(first["links"]["fitted_glb"]) as glb:
        assert drawing.json["shapes"] == []  # nobody asked for any
        assert b"sternum_upper" not in glb.data
    moved = picked | {"umbilicus": np.add(picked["umbilicus"], [0.0, 8.0, 0.0]).tolist()}
    again = client.post("/api/fits", json=body | {"landmarks": moved, "start_from": first["id"]}).json
    done = ended(service, again["id"])
    assert (done.state, done.stance) == ("done", "supine")
    assert done.iterations < get_fit(service.storage, first["id"]).iterations
    assert client.get(again["links"]["self"]).json["start_from"] == first["id"]
    received = client.get(again["links"]["events"] + ".json").json["events"]
    before = client.get(first["links"]["events"] + ".json").json["events"]
    assert "goes on from" in received[0]["event"]["stance_reason"]
    start, end = ({node["name"]: node for node in event["event"]["nodes"]} for event in (received[1], before[-2]))
    for name, node in end.items():
        assert np.allclose(node.get("translation", 0.0), start[name].get("translation", 0.0), atol=1e-6)
        assert np.allclose(node.get("weights", 0.0), start[name].get("weights", 0.0), atol=1e-6)
    client.delete(scan["links"]["self"])


@pytest.mark.slow
def test_the_model_follows_a_landmark_that_is_dragged_and_nothing_is_kept(real: tuple[Service, FlaskClient]) -> None:
    service, client = real
    scan = client.post("/api/examples/standing").json
    picked = scan["example_landmarks"]["landmarks"]
    links = client.post("/api/fits", json={"scan": scan["id"], "landmarks": picked}).json["links"]
    fit_id = links["self"].rsplit("/", 1)[1]
    assert ended(service, fit_id).state == "done"
    before = client.get(links["events"] + ".json").json["events"]
    rig = read_rig(default_rig_path())

    def at(nodes: list[dict]) -> np.ndarray:
        return 1e3 * pose(rig, posed_by_nodes(rig, nodes))

    still = client.post(links["moved"], json={"landmarks": picked}).json
    assert np.linalg.norm(at(still["nodes"]) - at(before[-2]["event"]["nodes"]), axis=1).mean() < 0.1
    moved = picked | {"nipple_L": np.add(picked["nipple_L"], [8.0, 8.0, 0.0]).tolist()}
    live = client.post(links["moved"], json={"landmarks": moved}).json
    fresh = client.post("/api/fits", json={"scan": scan["id"], "landmarks": moved}).json
    ended(service, fresh["id"])
    result = client.get(fresh["links"]["events"] + ".json").json["events"][-2]["event"]["nodes"]
    assert np.linalg.norm(at(live["nodes"]) - at(result), axis=1).mean() < 0.3
    assert np.linalg.norm(at(live["nodes"]) - at(still["nodes"]), axis=1).max() > 2.0

    assert client.get(links["events"] + ".json").json["events"] == before
    for wrong, word in (("umbilikus", "umbilikus"), ("xiphoid", "outside of the scan")):
        assert word in problem(client.post(links["moved"], json={"landmarks": {wrong: [9e3, 0.0, 0.0]}}), 422)
    endless = problem(client.post(links["moved"], json={"landmarks": {"xiphoid": [1e308, 0.0, 0.0]}}), 422)
    assert endless.startswith("xiphoid lies more than 1,000 km outside of the scan;")
    nowhere = {name: np.add(place, [0.0, 0.0, 200.0]).tolist() for name, place in picked.items()}
    assert client.post(links["moved"], json={"landmarks": nowhere}).status_code == 200
    again = [client.post(links["moved"], json={"landmarks": moved}).json for _ in range(3)][-1]  # it came back
    assert np.linalg.norm(at(again["nodes"]) - at(live["nodes"]), axis=1).mean() < 0.1
    assert {fit_id, scan["id"]} <= set(service.pool.idle_keys)
    client.delete(scan["links"]["self"])
    assert not {fit_id, scan["id"]} & set(service.pool.idle_keys)
    problem(client.post(links["moved"], json={"landmarks": picked}), 404)


@pytest.mark.slow
def test_a_pattern_follows_a_hand_and_its_parameters_give_the_same_lines_in_the_plan(
    real: tuple[Service, FlaskClient],
) -> None:
    service, client = real
    scan = client.post("/api/examples/standing").json
    result = fitted(service, client, scan, client.get(scan["links"]["landmarks"]).json["landmarks"])
    (fit,) = client.get(f"/api/scans/{scan['id']}/fits").json["fits"]
    place = f"/api/fits/{fit['id']}/pattern"
    first = client.post(place, json={"name": "vertical", "parameters": {"side": "L"}})
    assert first.status_code == 200, first.json
    handle = next(each for each in first.json["handles"] if each["name"] == "end_L")
    to = [at + 4.0 * step for at, step in zip(handle["at_mm"], handle["grows"], strict=True)]
    question = {"name": "vertical", "parameters": {"side": "L"}, "drag": {"handle": "end_L", "to": to}}
    dragged = client.post(place, json=question).json
    assert dragged["parameters"]["above_fold_mm"] > 26.0
    assert dragged["limit"] == ""
    lines = {shape["name"]: shape["points"] for shape in first.json["shapes"]}
    moved = {shape["name"] for shape in dragged["shapes"] if shape["points"] != lines[shape["name"]]}
    assert moved == {"vertical_L"}
    item = {"kind": "pattern", "id": "p", "scan": scan["id"], "name": "vertical", "parameters": dragged["parameters"]}
    nipple, shoulder = (1e3 * np.array(result["landmarks"][name]) for name in ("nipple_L", "acromion_L"))  # from metres
    lesion = {"kind": "lesion", "id": "m", "scan": scan["id"], "name": "MRI 1", "radius_mm": 6.0}
    items = [item, lesion | {"center": (0.7 * nipple + 0.3 * shoulder).tolist()}]
    assert client.put(scan["links"]["plan"], json={"items": items}, headers={"If-Match": '"0"'}).status_code == 200
    planned = client.get(f"/api/fits/{fit['id']}/plan.json").json
    assert planned["missing"] == []
    (found,) = planned["lesions"]
    assert (found["id"], found["error_mm"], found["carried"]) == ("m", 0.0, False)
    assert np.allclose(1e3 * np.array(found["center"]), items[1]["center"], atol=1e-2)
    assert planned["shapes"].pop()["item"] == "m"
    for shape, same in zip(dragged["shapes"], planned["shapes"], strict=True):
        assert (shape["name"], shape["points"]) == (same["name"], same["points"])
        assert shape["error_mm"] == same["error_mm"]
    for wrong, status, sentence in (
        ({"name": "vertical", "parameters": {"width_mm": 500}}, 422, "width_mm of vertical cannot be 500"),
        ({"name": "wings"}, 422, '"wings" is not a pattern'),
        ({"name": "vertical", "drag": {"handle": "end_L", "to": [9e3, 0, 0]}}, 422, "outside of the scan"),
        ({"name": "vertical", "drag": {"handle": "nose_L", "to": to}}, 422, "handle of vertical"),
    ):
        answer = client.post(place, json=wrong)
        assert (answer.status_code, sentence in answer.json["detail"]) == (status, True), answer.json
    assert {fit["id"], scan["id"]} <= set(service.pool.idle_keys)
    assert client.delete(scan["links"]["self"]).status_code == 204
    assert not {fit["id"], scan["id"]} & set(service.pool.idle_keys)
    assert client.post(place, json={"name": "vertical"}).status_code == 404
