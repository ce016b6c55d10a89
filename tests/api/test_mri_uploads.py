"""An MRI as a zip of DICOM files, uploaded: the series is asked about, and nothing of the headers comes back."""

import io
import json
import zipfile

import numpy as np
from flask.testing import FlaskClient
from helpers.chest_image import chest_image
from helpers.dicom_files import Series, files, zipped

from breastrig.scan.images.image import ImageVolume


def test_an_upload_is_asked_about_and_sent_again(client: FlaskClient) -> None:
    small = ImageVolume(chest_image().values[::2, ::2], chest_image().affine @ np.diag([2.0, 2.0, 1.0, 1.0]))
    data = zipped(files(Series(small, "t1 fett", 1), Series(small, "t2 stir", 2)), zipfile.ZIP_DEFLATED)
    answer = client.post("/api/scans", data={"file": (io.BytesIO(data), "mri.zip")})
    assert answer.status_code == 422
    assert answer.json is not None
    question = answer.json["question"]
    assert (question["field"], len(question["choices"])) == ("series", 2)
    chosen = question["choices"][0]["value"]
    taken = client.post("/api/scans", data={"file": (io.BytesIO(data), "mri.zip"), "series": chosen})
    assert taken.status_code == 201, taken.json
    assert taken.json is not None
    assert taken.json["image"]["shape"] == [47, 30, 40]
    assert "t1 fett" not in json.dumps(taken.json)
    assert taken.json["stance"]["proposed"] == "prone"
    client.delete(taken.json["links"]["self"])
