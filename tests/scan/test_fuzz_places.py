"""Scans anywhere in space, in any unit: exact to a hundredth of a millimetre, or their notes say why not."""

import re

import numpy as np
from helpers.damage import bounded
from helpers.fuzz_table import count
from helpers.gltf_evaluator import GltfScene
from helpers.refusals import is_sentence
from helpers.scan_files import ply_text
from helpers.toy_rig import toy_rig
from hypothesis import given
from hypothesis import strategies as st

from breastrig.core.errors import BadInput
from breastrig.core.units import METRES_PER_UNIT
from breastrig.gltf.mesh_glb import mesh_glb
from breastrig.report.files.geometry_files import surface_ply
from breastrig.scan.clean import clean
from breastrig.scan.read import read_scan

EXACT = 1e-5  # m
PLACES = st.tuples(*3 * [st.one_of(st.floats(-200.0, 200.0), st.floats(-1e9, 1e9), st.floats())])
ROUNDED = re.compile(r"its file rounds them to ([\d.e+-]+) mm")


@bounded(150)
@given(PLACES, st.sampled_from(sorted(METRES_PER_UNIT)), st.sampled_from([b"float", b"double"]))
def test_a_scan_anywhere(place: tuple[float, float, float], unit: str, kind: bytes) -> None:
    rig = toy_rig()
    with np.errstate(all="ignore"):
        wanted = rig.template + np.array(place)  # m
        data = ply_text(wanted / METRES_PER_UNIT[unit], rig.faces).replace(b"float", kind)
    refused = None
    try:
        scan = read_scan(data, "ply", unit)
        surface = clean(scan)
    except BadInput as error:
        refused = error
    count("scan somewhere", "read" if refused is None else "refused")
    if refused is not None:
        assert is_sentence(refused)
        assert len(str(refused)) < 300
        assert not np.abs(place).max() <= 1e4  # whatever is nearer is read
        return
    rounding = [float(found[1]) for note in scan.notes if (found := ROUNDED.search(note))]
    allowed = EXACT if not rounding else 1e-3 * rounding[0]
    assert np.abs(scan.vertices - wanted).max() <= allowed
    shown = GltfScene(mesh_glb(scan.vertices, scan.faces)).positions("mesh")
    assert np.abs(shown - scan.vertices).max() < EXACT
    again = read_scan(surface_ply(surface.vertices, surface.faces, scan.metres_per_unit), "ply", unit)
    assert np.abs(again.vertices - surface.vertices).max() < EXACT
