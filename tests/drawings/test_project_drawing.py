"""Drawings laid on surfaces whose answer is known."""

from dataclasses import replace

import numpy as np

from breastrig.correspondence.target import ScanTarget
from breastrig.drawings.project_drawing import on_scan
from breastrig.rig.model import Rig
from breastrig.scan.clean import compact


def test_a_drawing_on_the_models_own_surface_stays_where_it_is(toy_rig: Rig) -> None:
    lines = on_scan(toy_rig, toy_rig.template, toy_rig.drawings[0], ScanTarget(toy_rig.template, toy_rig.faces))
    search = ScanTarget(toy_rig.template, toy_rig.faces).search
    for line, shape in zip(lines, toy_rig.drawings[0].shapes, strict=True):
        assert (line.name, line.closed) == (shape.name, shape.closed)
        on_the_skin = line.points[~line.bridged]
        assert search.query(on_the_skin).distances.max() < 1e-6


def test_a_hole_in_the_scan_is_bridged_and_said(toy_rig: Rig) -> None:
    drawing = replace(toy_rig.drawings[0], shapes=toy_rig.drawings[0].shapes[:1])
    used = np.unique(toy_rig.faces[drawing.shapes[0].points.faces[: len(drawing.shapes[0].points) // 2]])
    kept = ~np.isin(toy_rig.faces, used).any(axis=1)
    holed = ScanTarget(*compact(toy_rig.template, toy_rig.faces[kept]))
    (line,) = on_scan(toy_rig, toy_rig.template, drawing, holed)
    assert line.bridged.any()
    assert np.isfinite(line.points).all()
    assert holed.search.query(line.points[~line.bridged]).distances.max(initial=0.0) < 1e-6
