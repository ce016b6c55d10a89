"""What is kept of a fit so that checks can be named for lines that are drawn later, without its scan.

A pick replaces what colours, form or its partner showed of the landmark, and tells of its own partner on the other side
(fitting/body/landmarks.py), as in the fit that would follow.

In its file: float64, the covariance's upper triangle row by row, for each vertex the factor from its deviation to its
radius once a landmark is picked, and whether it is seen, two numbers, then NUMBERS for each landmark of the rig, and
where the scan's size is not known a number more for each vertex; empty where nothing can be checked.
"""

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from breastrig.colour.features.observation import Observation
from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.core.stances import PRONE, split_side
from breastrig.fitting.body.landmarks import UNSHOWN_ERROR, expected_gaps
from breastrig.fitting.checks.choose import Gaussian, ModelLine, Observable, Widths
from breastrig.fitting.fit import along
from breastrig.fitting.posterior import Posterior, laid_on_scan
from breastrig.fitting.uncertainty.radii import HOLDS_90, Radii, radii
from breastrig.rig.model import Rig
from breastrig.rig.modes import mode_count
from breastrig.rig.parameters import RigParameters
from breastrig.rig.state import BodyState


@dataclass(frozen=True, eq=False)
class Places:
    """Where a fit expects the rig's L landmarks on the scan."""

    points: Array  # (L, 3) m, on the scan's skin
    normals: Array  # (L, 3) unit, of the scan there
    radii: Array  # (L,) m, that hold the true places with 90 %
    shown: Booleans  # (L,) which of them the scan shows


def places_of(posterior: Posterior, known: Radii, seen: Mapping[str, Observation]) -> Places:
    """The places of landmarks around which a person looks for them; `known` radii of the fit, `seen` in the colours."""
    target, around = posterior.task.target, radii(posterior, expected=True)
    assert around is not None
    sizes = {name: float(np.hypot(radius, known.lost)) for name, radius in around.landmarks.items()}
    sizes |= {name: HOLDS_90 * each.error for name, each in seen.items()}
    points, shown = laid_on_scan(posterior, {name: each.place for name, each in seen.items()})
    nearest = target.search.query(points)
    normals = target.face_normals[nearest.faces]
    return Places(nearest.points, normals, np.array([*sizes.values()]), shown)


def observable_landmarks(posterior: Posterior, shown: Booleans, checked: Collection[str]) -> Observable:
    """The landmarks that the scan shows ((L,) `shown`) and a person has not `checked` yet."""
    task, rig = posterior.task, posterior.task.rig
    recipe, stage, names = task.recipe, task.recipe.stages[-1], tuple(rig.landmark_names)
    index = {name: k for k, name in enumerate(names)}
    temperature = along(stage.temperature, 1.0)
    replaced = np.zeros((len(names), 3, 3))
    if posterior.picks is not None:
        for each, root in zip(posterior.picks.observations, posterior.picks.whitening, strict=True):
            replaced[index[each.name]] += root.T @ root
    if stage.looks_at_form or task.stance == PRONE:
        for name, each in posterior.relief.items():
            replaced[index[name]] += np.linalg.inv(each.covariance) / (temperature * recipe.observed.form) ** 2
    shared = {each.name: np.linalg.inv(each.covariance) / temperature**2 for each in posterior.partners or ()}
    for name, information in shared.items():
        replaced[index[name]] += information
    partners = {}
    for landmark in rig.landmarks if stage.looks_at_form or task.stance == PRONE else ():
        alike, other = recipe.partners.get(split_side(landmark.name)[0]), landmark.mirror
        if alike is None or other == landmark.name or other in task.landmarks:
            continue
        error = math.hypot(alike, 0.0 if shown[index[other]] else UNSHOWN_ERROR)
        more = 1.0 / (temperature * error) ** 2 - np.trace(shared.get(other, np.zeros((3, 3)))) / 3.0
        partners[index[landmark.name]] = index[other], max(float(more), 0.0)
    gaps = expected_gaps(posterior.state, task.stance)
    beside = np.array([gaps[name].covariance for name in names]).reshape(-1, 3, 3)
    still = np.array([name not in checked for name in names], dtype=np.bool_) & shown
    return Observable(names, still, 1.0 / (temperature * recipe.observed.landmark) ** 2, replaced, partners, beside)


UPPER = np.triu_indices(3)
NUMBERS = 22  # open, point (3), normal (3), radius, shown, replaced information (6), known of its partner, beside (6)


@dataclass(frozen=True, eq=False)
class CheckBasis:
    """The posterior, the landmarks that can be checked, and where they are expected."""

    covariance: Array  # (P, P) of a step from the fit's parameters
    once_picked: Array  # (V,) from a vertex's deviation to its radius as soon as a landmark is picked
    seen: Booleans  # (V,) vertices on skin that the scan shows
    lost: Array | float  # m, (V,) or one for all, in radii whatever is picked: for another way to lie, or another size
    observable: Observable
    places: Places

    def gaussian(self, state: BodyState, vertices: Integers) -> Gaussian:
        """Where the rig's landmarks and these (N,) vertices lie together, around a fit's state."""
        if modes := len(self.covariance) - state.dof:  # the files of a fit have none
            state = BodyState(state.rig, replace(state.x, modes=np.zeros(modes)))
        rig, axes = state.rig, np.eye(3)
        points = rig.landmark_points()
        corners = rig.faces[points.faces].ravel()
        ways = [state.posed.rows(corners, (points.barycentric[:, :, None] * axis).reshape(-1, 3)) for axis in axes]
        landmarks = np.stack([rows[0::3] + rows[1::3] + rows[2::3] for rows in ways], axis=1)  # (L, 3, P)
        moved = np.stack([state.posed.rows(vertices, np.tile(axis, (len(vertices), 1))) for axis in axes], axis=1)
        of_landmarks = landmarks.reshape(-1, landmarks.shape[2])
        spread = np.asarray(moved @ self.covariance)  # (N, 3, P)
        return Gaussian(
            of_landmarks @ self.covariance @ of_landmarks.T,
            spread @ of_landmarks.T,
            np.einsum("nip,nip->n", spread, moved),
        )

    def widths(self, lines: Sequence[ModelLine]) -> tuple[Integers, Widths]:
        """((N,) vertices of the model on which the lines lie, the widths of the lines on these)."""
        vertices = np.unique(np.concatenate([line.corners.ravel() for line in lines]))
        own = [replace(line, corners=np.searchsorted(vertices, line.corners)) for line in lines]
        lost = self.lost[vertices] if isinstance(self.lost, np.ndarray) else self.lost
        return vertices, Widths(own, self.once_picked[vertices], lost)


def check_basis(
    posterior: Posterior, known: Radii, seen: Mapping[str, Observation], checked: Collection[str]
) -> CheckBasis:
    """The basis of a finished fit with its `known` radii and the landmarks that were `seen` in the colours.

    `checked`: landmarks that nobody needs to look at.
    """
    places = places_of(posterior, known, seen)
    observable = observable_landmarks(posterior, places.shown, checked)
    lost = np.hypot(known.lost, known.size) if isinstance(known.size, np.ndarray) else known.lost
    return CheckBasis(posterior.covariance(), known.once_picked, known.seen, lost, observable, places)


def on_vertices(vertices: Integers) -> ModelLine:
    """A line whose places are these (M,) vertices of the model."""
    return ModelLine(np.repeat(vertices[:, None], 3, axis=1), np.tile([1.0, 0.0, 0.0], (len(vertices), 1)))


def basis_bytes(basis: CheckBasis | None) -> bytes:
    """The file."""
    if basis is None:
        return b""
    observable, places = basis.observable, basis.places
    rows = np.zeros((len(observable.names), NUMBERS))
    rows[:, 0], rows[:, 1:4], rows[:, 4:7] = observable.open, places.points, places.normals
    rows[:, 7], rows[:, 8] = places.radii, places.shown
    rows[:, 9:15] = observable.replaced[:, UPPER[0], UPPER[1]]
    rows[:, 16:22] = observable.beside[:, UPPER[0], UPPER[1]]
    for index, (_, shared) in observable.partners.items():
        rows[index, 15] = shared
    covariance = basis.covariance[np.triu_indices(len(basis.covariance))]
    each = basis.lost if isinstance(basis.lost, np.ndarray) else np.zeros(0)
    single = np.array([0.0 if len(each) else basis.lost, observable.pick])
    parts = [covariance, basis.once_picked, basis.seen, single, rows.ravel(), each]
    return np.concatenate(parts).astype("<f8").tobytes()


def _sizes(rig: Rig, x: RigParameters) -> tuple[int, int]:
    """Possible P of a covariance: without modes and with them."""
    return x.dof, x.dof + mode_count(rig)


def _upper(size: int) -> int:
    """Numbers in a matrix's upper triangle."""
    return size * (size + 1) // 2


def read_basis(content: bytes, rig: Rig, x: RigParameters) -> CheckBasis | None:
    """The file's basis; None for an empty file, one of another rig, or one that no fit wrote."""
    names, vertices = tuple(rig.landmark_names), len(rig.template)
    others = [vertices, vertices, 2, NUMBERS * len(names)]
    numbers_in = {_upper(size) + sum(others) + more: size for size in _sizes(rig, x) for more in (0, vertices)}
    size = numbers_in.get(len(content) // 8)
    if size is None or len(content) % 8:
        return None
    counts = np.cumsum([_upper(size), *others])
    numbers = np.frombuffer(content, dtype="<f8").astype(np.float64)
    if not np.isfinite(numbers).all():
        return None
    upper, once_picked, seen, single, rows, each = np.split(numbers, counts)
    rows = rows.reshape(len(names), NUMBERS)
    covariance = np.zeros((size, size))
    covariance[np.triu_indices(size)] = upper
    covariance += np.triu(covariance, 1).T
    replaced, beside = np.zeros((2, len(names), 3, 3))
    for matrices, upper in ((replaced, rows[:, 9:15]), (beside, rows[:, 16:22])):
        matrices[:, UPPER[0], UPPER[1]] = matrices[:, UPPER[1], UPPER[0]] = upper
    mirror = {landmark.name: names.index(landmark.mirror) for landmark in rig.landmarks}
    partners = {
        index: (mirror[name], float(rows[index, 15])) for index, name in enumerate(names) if rows[index, 15] > 0.0
    }
    observable = Observable(names, rows[:, 0] > 0.0, float(single[1]), replaced, partners, beside)
    places = Places(rows[:, 1:4], rows[:, 4:7], rows[:, 7], rows[:, 8] > 0.0)
    lost = each if len(each) else float(single[0])
    return CheckBasis(covariance, once_picked, seen > 0.0, lost, observable, places)
