"""An MRI's label map as a scan of a patient: what it shows inside is in her plan by itself."""

import gzip
import io

import pytest
from flask.testing import FlaskClient
from helpers.label_maps import LESION, RADIUS, body_labels, nifti


@pytest.mark.slow
@pytest.mark.parametrize("name", ["Jane Doe.nii.gz", "IM000001", "1.3.6.1.4.1.9590.100.1.2"])
def test_a_lesion_of_a_label_map_is_an_item_of_the_plan(client: FlaskClient, name: str) -> None:
    data = gzip.compress(nifti(body_labels()))
    answer = client.post("/api/scans", data={"file": (io.BytesIO(data), name)})
    assert answer.status_code == 201, answer.json
    assert answer.json is not None
    scan = answer.json
    assert (scan["unit"], scan["triangles"] > 20_000) == ("mm", True)
    assert (scan["stance"]["proposed"], "breast MRI" in scan["stance"]["reason"]) == ("prone", True)
    plan = client.get(scan["links"]["plan"]).json
    assert plan is not None
    (lesion,) = plan["items"]
    assert (lesion["kind"], lesion["scan"], lesion["name"]) == ("lesion", scan["id"], "Label 2")
    assert lesion["center"] == pytest.approx(LESION.tolist(), abs=0.2)
    assert lesion["radius_mm"] == pytest.approx(RADIUS, abs=0.1)
    assert client.delete(scan["links"]["self"]).status_code == 204
    assert client.get(scan["links"]["plan"]).status_code == 404
