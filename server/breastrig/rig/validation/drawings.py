"""Rules for the drawings, so that a new file beside the rig can be trusted: each names the line that breaks it."""

import re

import numpy as np
from scipy.spatial import cKDTree

from breastrig.core.arrays import Array
from breastrig.rig.model import DrawnShape, ModelDrawing, Rig
from breastrig.rig.validation.finding import Finding, named
from breastrig.rig.validation.symmetry import FLIP, is_symmetric, other_side

JUMP = 0.025  # m between neighbours on the template; more may be a point that was missed, or two lines in one,
UNEVEN = 3.0  # when it is more than this many median steps of the line, too: other rigs may draw coarsely
TOUCH = 1e-4  # m; ends as near as this are one point
MIRROR = 0.004  # m from a line's mirror image to its partner: half a step of our lines
COLOUR = re.compile("#[0-9a-fA-F]{6}")
Lines = list[tuple[ModelDrawing, DrawnShape]]


def on_triangle(barycentric: Array) -> bool:
    """Whether every row lies inside its triangle."""
    rows = np.atleast_2d(barycentric)
    return bool(rows.shape[1] == 3 and (rows > -1e-5).all() and (np.abs(rows.sum(axis=1) - 1.0) < 1e-5).all())


def drawing_findings(rig: Rig) -> list[Finding]:
    """Findings on the drawings; requires indices in range."""
    lines = [(drawing, shape) for drawing in rig.drawings for shape in drawing.shapes]
    on_surface = _on_the_surface(rig, lines)
    findings = [on_surface, _colours(lines)]
    if on_surface.ok:
        findings += [_steps(rig, lines), _ends(rig, lines), _corners(lines), _sides(rig, lines)]
    return findings


def _at(rig: Rig, shape: DrawnShape) -> Array:
    return shape.points.positions(rig.template, rig.faces)


def _found(name: str, wrong: list[str], why: str, right: str) -> Finding:
    return Finding(name, not wrong, f"{why}: {named(wrong)}." if wrong else right)


def _called(drawing: ModelDrawing, shape: DrawnShape) -> str:
    return f"{shape.name} of {drawing.name}"


def _on_the_surface(rig: Rig, lines: Lines) -> Finding:
    wrong = [
        _called(drawing, shape)
        for drawing, shape in lines
        if len(shape.points) < (3 if shape.closed else 2) or not on_triangle(shape.points.barycentric)
    ]
    right = f"{len(rig.drawings)} drawings"
    return _found("drawings lie on the surface", wrong, "too short or beside its triangles", right)


def _colours(lines: Lines) -> Finding:
    wrong = [_called(drawing, shape) for drawing, shape in lines if not COLOUR.fullmatch(shape.color)]
    return _found("lines have a colour", wrong, "the colour is not #rrggbb", f"{len(lines)} lines")


def _steps(rig: Rig, lines: Lines) -> Finding:
    wrong, longest = [], 0.0
    for drawing, shape in lines:
        at = _at(rig, shape)
        steps = np.linalg.norm(np.diff(np.concatenate([at, at[:1]]) if shape.closed else at, axis=0), axis=1)
        longest = max(longest, float(steps.max()))
        if steps.max() > max(JUMP, UNEVEN * float(np.median(steps))):
            wrong.append(
                f"{_called(drawing, shape)} ({1e3 * float(steps.max()):.0f} mm at point {int(steps.argmax())})"
            )
    right = f"at most {1e3 * longest:.1f} mm from point to point"
    return _found("lines run without jumps", wrong, "neighbours lie far apart", right)


def _ends(rig: Rig, lines: Lines) -> Finding:
    """Checks that no closed line repeats its first point, and that a line that returns is closed."""
    wrong = []
    for drawing, shape in lines:
        at = _at(rig, shape)
        if np.linalg.norm(at[0] - at[-1]) < TOUCH and len(at) > 2:
            wrong.append(f"{_called(drawing, shape)} is {'closed twice' if shape.closed else 'open but returns'}")
    return _found("open and closed lines say so", wrong, "the first and the last point are one", f"{len(lines)} lines")


def _corners(lines: Lines) -> Finding:
    wrong = [
        _called(drawing, shape)
        for drawing, shape in lines
        if sorted(set(shape.corners)) != list(shape.corners)
        or any(not 0 <= corner < len(shape.points) for corner in shape.corners)
    ]
    count = sum(len(shape.corners) for _, shape in lines)
    return _found("corners are points of their line", wrong, "not rising numbers of its points", f"{count} corners")


def _sides(rig: Rig, lines: Lines) -> Finding:
    """Checks the sides of lines whose partner is there."""
    name = "lines of both sides mirror each other"
    if not is_symmetric(rig):
        return Finding(name, True, "the rig claims no symmetry")
    wrong, pairs = [], 0
    for drawing, shape in lines:
        by_name = {other.name: other for other in drawing.shapes}
        partner = by_name.get(other_side(shape.name))
        if partner is None or partner is shape or shape.name.endswith("_R"):
            continue
        pairs += 1
        here, there = _at(rig, shape) * FLIP, _at(rig, partner)
        gap = max(float(np.max(cKDTree(a).query(b)[0])) for a, b in ((here, there), (there, here)))
        alike = (shape.closed, shape.color) == (partner.closed, partner.color)
        if gap > MIRROR or not alike:
            what = f"{1e3 * gap:.0f} mm apart" if alike else "colour or closing differs"
            wrong.append(f"{_called(drawing, shape)} and {partner.name} ({what})")
    return _found(name, wrong, "not alike", f"{pairs} pairs")
