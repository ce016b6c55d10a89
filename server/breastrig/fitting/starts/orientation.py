"""A fit's start: from its landmarks, or from the scan alone, its direction up and the part of the body it shows.

Landmarks are met by a similarity that trusts the majority (iteratively reweighted Umeyama), so that one pick on the
wrong place or two exchanged sides do not turn it.

Without them the rest pose is tried all around (starts/rigid_search.py), and on a part of a body at a few heights more
(starts/hypotheses.py): the rest pose covers what there is, and would shrink into it.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import softmax

from breastrig.core.arrays import Array
from breastrig.core.stances import PRONE
from breastrig.correspondence.target import ScanTarget
from breastrig.fitting.recipe import Outliers
from breastrig.fitting.starts.hypotheses import Opening, ranked
from breastrig.fitting.starts.rigid_search import OBLIQUE, rest_place, turned_from, turns_about, turns_beside, turns_to
from breastrig.geometry.normals import face_normals
from breastrig.geometry.rotations import exp_so3
from breastrig.least_squares.problem import log_student
from breastrig.relief.prone import seen_from
from breastrig.rig.model import Rig
from breastrig.rig.parameters import RigParameters
from breastrig.rig.similarity import Similarity, body_axes, similar_parameters, umeyama
from breastrig.rig.skinning import pose
from breastrig.rig.stance_priors import mean_weights
from breastrig.scan.clean import MIN_TRIANGLES, compact
from breastrig.scan.orient import Frame

TRUST = 0.04  # m; patients' landmarks lie within about 3 cm of a similarity of the model's
ADULT_SCALE = (0.75, 1.3)  # of the model
MIN_LANDMARKS = 3  # fewer leave the similarity open
SURE_LANDMARKS = 6  # so many never lie on one line
PERSON = 1.3  # m; scans of trunks with head and arms reach 1 m, so this is a person from head to feet
STATURE = 1.55  # m, of a woman for whom the model's trunk needs no scale
TRUNK = (0.47, 0.9)  # shares of the stature: from the crotch to the chin
HEIGHTS = (0.0, 0.03, -0.03)  # m along a part of a body; half of the basin
TILT = 0.22  # rad, by which the mean normal of a prone front is turned to the head: 0.09 to 0.36
PRONE_SCALE = 1.05  # of the trunk; hanging breasts say nothing of it
CONTRADICTED = 0.15  # share by which another position is better: right maps have up to 0.11, reversed ones 0.12 to 0.95
AGREED = 0.08  # m, mean distance of the landmarks to a start that they agree with; the given scans' are under 5 cm


def trusted_similarity(model: Array, picked: Array) -> tuple[Similarity, Array]:
    """A similarity that the majority of the (L, 3) pairs agree on, and the (L,) residuals in m."""
    found = umeyama(model, picked)
    residual = np.linalg.norm(found.apply(model) - picked, axis=1)
    for scale in (4.0 * TRUST, 2.0 * TRUST, TRUST, TRUST, TRUST):
        found = umeyama(model, picked, 1.0 / (1.0 + (residual / scale) ** 2) ** 2)
        residual = np.linalg.norm(found.apply(model) - picked, axis=1)
    return found, residual


def start_from_landmarks(rig: Rig, landmarks: dict[str, Array]) -> RigParameters:
    """The rest pose on three or more landmarks (3,) m; the scale is kept within what adults have."""
    names = tuple(landmarks)
    model = rig.landmark_points(names).positions(rig.template, rig.faces)
    picked = np.array([landmarks[name] for name in names])
    found, residual = trusted_similarity(model, picked)
    scale = float(np.clip(found.scale, *ADULT_SCALE))
    share = 1.0 / (1.0 + (residual / TRUST) ** 2) ** 2
    shift = share @ (picked - scale * model @ found.rotation.T) / share.sum()
    return similar_parameters(rig, Similarity(scale, found.rotation, shift))


@dataclass(frozen=True, eq=False)
class Start:
    """A rest pose on a scan."""

    rig: Rig
    similarity: Similarity  # of the rest pose
    margin: float  # how much worse the best try in another turn is, as a share of the score
    opening: Opening | None = None  # what was fitted to find it

    @property
    def parameters(self) -> RigParameters:
        return similar_parameters(self.rig, self.similarity)


def trunks(target: ScanTarget, fronts: Array, known: Array | None = None) -> Iterator[tuple[ScanTarget, Array, float]]:
    """The scan, the body axes to try and the model's scale; where it may be a person from head to feet also where the
    trunk is, either way up, or as (3, 3) `known` axes have it."""
    turns = turns_to(fronts) if known is None else turns_beside(known)
    yield target, turns, 1.0
    middle = target.vertices.mean(axis=0)
    axis = np.linalg.eigh(np.cov((target.vertices - middle).T))[1][:, -1]
    heights = target.vertices @ axis
    ups = (axis, -axis) if known is None else (axis * np.sign(axis @ known[:, 1]),)
    for up in ups if np.ptp(heights) > PERSON else ():
        share = (target.vertices @ up - (target.vertices @ up).min()) / np.ptp(heights)
        kept = ((share > TRUNK[0]) & (share < TRUNK[1]))[target.faces].all(axis=1)
        if np.count_nonzero(kept) > MIN_TRIANGLES:
            part = ScanTarget(*compact(target.vertices, target.faces[kept]))
            yield part, turns_about(up) if known is None else turns, np.ptp(heights) / STATURE


def start_from_scan(rig: Rig, target: ScanTarget, fronts: Array, known: Array | None = None) -> Start:
    """The best rest pose for a scan whose front is about one of (N, 3) unit directions, or near (3, 3) `known` axes."""
    place = min(
        (rest_place(rig.template, rig.faces, *part, known) for part in trunks(target, fronts, known)),
        key=lambda each: each.uncovered,
    )
    if not place.shows_a_part:
        return Start(rig, place.similarity, place.margin)
    stance = "standing" if target.table is None else "supine"
    up = place.similarity.rotation[:, 1]
    moved = [replace(place.similarity, translation=place.similarity.translation + each * up) for each in HEIGHTS]
    best, *_ = ranked(rig, target, moved, stance)
    return Start(rig, best.place or place.similarity, place.margin, best)


def prone_start(rig: Rig, target: ScanTarget, frame: Frame) -> Start:
    """The prone rest pose on what the hanging breasts of a scan show.

    Beside known axes of the body, which may lie obliquely in the scanner, it is where the search has it: within 2 cm on
    maps cut in many ways, where the two foremost places need not be breasts.
    """
    body, known = _prone_body(rig), frame.known
    if known is not None:
        found = rest_place(body, rig.faces, target, turns_beside(known), known=known)
        return Start(rig, found.similarity, found.margin)
    found = rest_place(body, rig.faces, target, turns_to(frame.fronts))
    side, _, towards = found.similarity.rotation.T
    front = frame.fronts[(frame.fronts @ towards).argmax()]
    left = side - (side @ front) * front
    left /= np.linalg.norm(left)
    axes = np.column_stack([left, np.cross(front, left), front]) @ exp_so3(np.array([TILT, 0.0, 0.0]))
    places = seen_from(target.vertices, target.faces, axes) or {}
    names = tuple(name for name in places if name in rig.landmark_names)
    if not names:
        return Start(rig, found.similarity, found.margin)
    model = rig.landmark_points(names).positions(body, rig.faces).mean(axis=0)
    seen = np.mean([places[name] for name in names], axis=0)
    return Start(rig, Similarity(PRONE_SCALE, axes, seen - PRONE_SCALE * axes @ model), found.margin)


def _prone_body(rig: Rig) -> Array:
    """(V, 3) m, at rest."""
    return rig.template + np.tensordot(mean_weights(rig, PRONE), rig.blendshapes, axes=1)


def contradicted(rig: Rig, target: ScanTarget, frame: Frame, stance: str) -> bool:
    """Whether the scan shows its body clearly another way round than the axes that its file says."""
    if frame.known is None:
        return False
    body = _prone_body(rig) if stance == PRONE else rig.template
    axes = np.concatenate([frame.known.T, -frame.known.T])
    here = rest_place(body, rig.faces, target, turns_beside(frame.known), known=frame.known)
    anywhere = rest_place(body, rig.faces, target, turns_to(axes))
    return here.score > (1.0 + CONTRADICTED) * anywhere.score


def best_start(
    rig: Rig,
    target: ScanTarget,
    landmarks: dict[str, Array],
    fronts: Callable[[], Array],
    known: Similarity | None = None,
    axes: Array | None = None,
) -> RigParameters:
    """The start for these landmarks ((3,) m by name) on a scan whose front is about one of (N, 3) directions.

    `known` is what start_from_scan has found for the scan before; it and `fronts` are needed only where landmarks do
    not say enough.

    Six and more landmarks place the body alone.  Three to five may lie nearly on a line (the breastbone, both
    collar bones and the notch) and leave a turn open: then the scan's own start is taken, if the landmarks agree.
    Landmarks that turn the body away from (3, 3) known `axes` do not place it.
    """

    def from_scan() -> RigParameters:
        if known is not None:
            return similar_parameters(rig, known)
        return start_from_scan(rig, target, fronts(), axes).parameters

    if len(landmarks) < MIN_LANDMARKS:
        return from_scan()
    by_landmarks = start_from_landmarks(rig, landmarks)
    if axes is not None and turned_from(body_axes(rig, pose(rig, by_landmarks)), axes, OBLIQUE):
        return from_scan()
    if len(landmarks) >= SURE_LANDMARKS:
        return by_landmarks
    by_scan = from_scan()
    return by_scan if agree(rig, by_scan, landmarks) else by_landmarks


def agree(rig: Rig, x: RigParameters, landmarks: Mapping[str, Array]) -> bool:
    """Whether landmarks ((3,) m by name, one or more) are about where the body posed by `x` has them."""
    places = rig.landmark_points(tuple(landmarks)).positions(pose(rig, x), rig.faces)
    return bool(np.linalg.norm(places - np.array([*landmarks.values()]), axis=1).mean() < AGREED)


FRAME = 10.0  # nats, times the cosine of the turn from known axes: 30 degrees cost 1.3, the wrong way round 20


def partner(rig: Rig, name: str) -> str:
    """The landmark on the other side."""
    return next(landmark.mirror for landmark in rig.landmarks if landmark.name == name)


def sides_exchanged(
    rig: Rig, landmarks: dict[str, Array], target: ScanTarget, outliers: Outliers, known: Array | None = None
) -> bool:
    """Whether the picks ((3,) m by name) as a whole make sense only with left and right exchanged.

    Few picks nearly in one plane fit the model's back as well as its front; which way the skin under them faces tells,
    and (3, 3) `known` axes of the body.
    """
    names = tuple(landmarks)
    if len(names) < MIN_LANDMARKS:
        return False
    picked = np.array([landmarks[name] for name in names])
    skin, normals = target.normals[target.vertex_tree.query(picked)[1]], face_normals(rig.template, rig.faces)
    nats = []
    for order in (names, tuple(partner(rig, name) for name in names)):
        points = rig.landmark_points(order)
        found, away = trusted_similarity(points.positions(rig.template, rig.faces), picked)
        cosines = np.einsum("mi,mi->m", normals[points.faces] @ found.rotation.T, skin)
        nats.append(float(log_student(away / outliers.template, 3).sum() + outliers.facing * cosines.sum()))
        if known is not None:
            nats[-1] += FRAME * 0.5 * (float(np.sum(found.rotation * known)) - 1.0)
    return bool(softmax([nats[0], np.log(outliers.slip) + nats[1]])[1] > outliers.sure)
