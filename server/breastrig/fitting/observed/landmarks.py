"""Landmarks that a scan's colours show, as observations of a fit beside the picks of others.

The form is fitted first and says where each landmark is expected, and how well it knows.  What colour shows near there
enters the normal equations as picks do, but with an error of its own: that of the observation, and that of the model,
whose landmark need not lie where a real body has it (body/landmarks.py).  So an areola moves the model's nipple
there without bending the rest, and form that says otherwise more clearly keeps its place.

Areolae are also observed for the measures, whether or not they placed the nipples, on scans with a texture: colours of
vertices are left out, for their triangles are as large as the differences that matter.
"""

from collections.abc import Collection, Mapping
from dataclasses import replace

import numpy as np

from breastrig.colour.areolae import ObservedAreola
from breastrig.colour.features.observation import Expectation, Observation
from breastrig.core.arrays import Array
from breastrig.core.stances import SIDES
from breastrig.energies.landmarks import LandmarkObservation
from breastrig.fitting.body.landmarks import expected_gaps
from breastrig.fitting.posterior import Posterior
from breastrig.fitting.task import FitTask
from breastrig.fitting.uncertainty.radii import HOLDS_90, radii
from breastrig.geometry.normals import unit_vectors, vertex_normals
from breastrig.rig.model import Rig
from breastrig.rig.parameters import RigParameters
from breastrig.rig.similarity import umeyama
from breastrig.rig.skinning import pose
from breastrig.rig.state import BodyState
from breastrig.scan.scan import Scan

IN_IMAGE = "seen in the image"
FAR = 2.2  # times the error of image and form together: a bump that is no nipple
UNKNOWN = 0.02  # m, error of the form with models of which nobody knows how far bodies are from them


def colour_observations(
    task: FitTask, fitted: RigParameters, margin: float | None, scan: Scan
) -> dict[str, Observation]:
    """The rig's landmarks that the scan's colours or image show; empty for a scan without, or of a single colour.

    `fitted` is the end of the `task`'s fit without them, `margin` the clarity of its start (Start.margin). Given
    landmarks are searched too, for those beside them.
    """
    if not scan.shows_colour and not scan.seen:
        return {}
    rig = task.rig
    known = radii(Posterior(task, fitted), margin)
    errors = {name: UNKNOWN if known is None else known.landmarks[name] / HOLDS_90 for name in rig.landmark_names}
    body, expected = expectations(rig, pose(rig, fitted), errors | dict.fromkeys(task.given, KNOWN), task.landmarks)
    if not scan.shows_colour:
        return seen_in_image(scan, expected)
    from breastrig.colour.features.observe import observed_landmarks  # loads image filters

    return observed_landmarks(scan, expected, body[:, 0], body[:, 1])


def seen_in_image(scan: Scan, expected: Mapping[str, Expectation]) -> dict[str, Observation]:
    """The landmarks that the scan's image shows, but for those far from where the form has them."""
    found = {}
    for each in scan.seen:
        error, form = each.radius / HOLDS_90, expected.get(each.name)
        if form is not None and np.linalg.norm(each.place - form.place) <= FAR * np.hypot(error, form.spread):
            found[each.name] = Observation(each.place, error**2 / 3.0 * np.eye(3), IN_IMAGE)
    return found


def expectations(
    rig: Rig, vertices: Array, errors: Mapping[str, float], picked: Mapping[str, Array]
) -> tuple[Array, dict[str, Expectation]]:
    """((3, 3) columns: the body's left, up and front, by name where the landmarks with these errors (m) are expected).

    By the fitted model of (V, 3) m `vertices`, or where they were `picked`, in the scan's frame.
    """
    points = rig.landmark_points()
    places = points.positions(vertices, rig.faces)
    outwards = unit_vectors(points.positions(vertex_normals(vertices, rig.faces), rig.faces))
    expected = {
        name: Expectation(np.asarray(picked.get(name, places[k])), outwards[k], errors[name])
        for k, name in enumerate(rig.landmark_names)
        if name in errors
    }
    return umeyama(points.positions(rig.template, rig.faces), places).rotation, expected


def areola_of(observation: Observation) -> ObservedAreola | None:
    """The areola that a nipple was found in, as measures have it."""
    areola = observation.areola
    return None if areola is None else ObservedAreola(2.0 * areola.radius, areola.diameter_half, areola.rim)


def followed(
    task: FitTask, shown: Mapping[str, Observation] | None, rejected: Collection[str]
) -> dict[str, Observation]:
    """Name -> the colour observations that the finished fit followed: those `shown` less those it `rejected`."""
    return {name: each for name, each in (shown or {}).items() if name in task.given.keys() - task.picked - {*rejected}}


def with_observations(task: FitTask, seen: Mapping[str, Observation], fitted: RigParameters) -> FitTask:
    """The task that continues from its fit, `fitted`, with the colours' observations of landmarks not yet given."""
    unpicked = {name: each for name, each in seen.items() if name not in task.given}
    if not unpicked:
        return task
    gaps, given = expected_gaps(BodyState(task.rig, fitted), task.stance), dict(task.given)
    for name, each in unpicked.items():
        own = each.error**2 / 2.0 + task.recipe.observed.landmark**2  # the skin has two axes
        covariance = own * np.eye(3) + gaps[name].covariance
        given[name] = LandmarkObservation(name, each.place, covariance, "colour", reason=each.reason)
    return replace(task, start=fitted, recipe=task.recipe.continued, given=given)


KNOWN = 0.006  # m, root mean square error of a fitted or picked nipple
NIPPLES = {f"nipple_{side}": side for side in SIDES}


def observed_areolae(
    rig: Rig,
    vertices: Array,
    picked: Mapping[str, Array],
    scan: Scan,
    observed: Mapping[str, Observation] | None = None,
) -> dict[str, ObservedAreola | None]:
    """Side -> the areola there, None where none is seen; empty for a scan without a texture.

    `vertices` (V, 3) m is the fitted model; landmarks count as `picked`.  `observed` is what was seen before the fit.
    """
    sides = {name: side for name, side in NIPPLES.items() if name in rig.landmark_names}
    if scan.colour_kind != "texture" or not sides:
        return {}
    from breastrig.colour.features.observe import observed_landmarks  # loads image filters

    if observed is None:
        body, expected = expectations(rig, vertices, dict.fromkeys(sides, KNOWN), picked)
        observed = observed_landmarks(scan, expected, body[:, 0], body[:, 1])
    found: dict[str, ObservedAreola | None] = {}
    for name, side in sides.items():
        found[side] = areola_of(observed[name]) if name in observed else None
    return found
