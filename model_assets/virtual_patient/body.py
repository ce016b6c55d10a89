"""The virtual patient's body from MakeHuman's CC0 data: an adult woman, slightly asymmetric, arms at ease.

Not made with our rig: MakeHuman's own targets, skin weights and joints shape and pose her, so that a fit to her
scan is no fit of the model to itself.
"""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix, vstack
from scipy.sparse.csgraph import connected_components
from steps.source import Array, Integers, Source
from steps.subdivide import subdivide

from breastrig.geometry.boundary import boundary_loops

NIPPLES = {"L": 8459, "R": 1787}  # MakeHuman's vertices
YOUNG = 0.70  # share of the 25-year-old against the 90-year-old: a woman in her forties
MUSCLE_WEIGHT = {"averageweight": 0.82, "maxweight": 0.18}
CUP = {"L": 0.34, "R": 0.25}  # share of the largest cup against the average one; the left breast is the larger one
SOFTNESS = {"L": 0.32, "R": 0.24}  # share of the least firm breast
EXTRA = (
    ("stomach/stomach-navel-in", 0.9),
    ("torso/torso-scale-depth-incr", 0.15),
    ("stomach/stomach-tone-decr", 0.35),
    ("hip/hip-scale-horiz-incr", 0.1),
)

BOX = (-0.03, 0.572, 0.40)  # m: lowest and highest height and half width that a torso scan can show

# Bones of MakeHuman's standard rig that turn together, the joint around which they turn, and what carries them.
HEAD = ("neck", "head", "jaw", "eye", "levator", "oculi", "orbicularis", "oris", "risorius", "special", "temporalis")
CHEST = ("spine03", "spine02", "spine01", "breast", *HEAD, "tongue")
FOREARM = ("lowerarm", "wrist", "finger", "metacarpal")
ARM = ("upperarm", *FOREARM)


@dataclass(frozen=True, eq=False)
class Turns:
    """Rotations of a posture, in degrees about the body's own axes."""

    lean: float  # of the chest towards the patient's left
    collar: dict[str, tuple[float, float]]  # side: (up, back)
    blade: dict[str, float]  # side: abduction of the shoulder blade's part
    arm: dict[str, tuple[float, float]]  # side: (abduction, backwards)
    elbow: tuple[float, float] | None = None  # of both forearms: (abduction, backwards) against the upper arm


@dataclass(frozen=True, eq=False)
class Body:
    """The fine surface, as a linear map from MakeHuman's vertices."""

    source: Source
    neutral: Array  # (S, 3) m, MakeHuman's vertices in MakeHuman's pose
    fine: csr_matrix  # (V, S) source vertices -> fine vertices
    faces: Integers  # (F, 3) triangles of the fine surface, upper body only

    def carried(self, field: Array) -> Array:
        """A (S, ...) field of the source on the fine vertices."""
        return np.asarray(self.fine @ field)

    def posed(self, turns: Turns) -> tuple[Array, dict[str, Array]]:
        """((V, 3) m: the fine surface in a posture, (3,) m: where the joint of each shoulder is then)."""
        vertices, shoulders = _posed(self.source, self.neutral, turns)
        return self.carried(vertices), shoulders

    @property
    def middle(self) -> Array:
        """(V,) m: the left-right coordinate of MakeHuman's symmetric base, 0 on the midline."""
        return self.carried(self.source.vertices)[:, 0]

    @property
    def arms(self) -> Array:
        """(V,) 0 on the trunk, 1 on the arms."""
        return self.carried(_weight(self.source, ARM, ""))

    @property
    def reach(self) -> Array:
        """(V,) how far out on an arm: 0 on the trunk and at the shoulder, 1 at the elbow, more on the forearm."""
        place, arms = self.carried(self.neutral), self.arms
        result = np.zeros(len(place))
        for side in ("l", "r"):
            shoulder, elbow = (self.source.joint(f"{side}-{name}", self.neutral) for name in ("shoulder", "elbow"))
            bone = elbow - shoulder
            here = (arms > 0.5) & (place[:, 0] * bone[0] > 0)
            result[here] = ((place[here] - shoulder) @ bone) / (bone @ bone)
        return result

    @property
    def breasts(self) -> Array:
        """(V,) 1 where MakeHuman's breast sizes differ most, 0 where they do not."""
        sizes = [f"breast/female-young-averagemuscle-averageweight-{cup}cup-averagefirmness" for cup in ("max", "min")]
        reach = np.linalg.norm(self.carried(self.source.target(sizes[0]) - self.source.target(sizes[1])), axis=1)
        return np.asarray(reach / reach.max())

    def nipple(self, side: str) -> int:
        """The fine vertex that Catmull and Clark's rule made of MakeHuman's nipple vertex."""
        return int(self.fine[:, [NIPPLES[side]]].toarray().argmax())


def virtual_patient(source: Source) -> Body:
    """The example patient's body before any posture."""
    neutral = source.vertices + _figure(source)
    return Body(source, neutral, *upper_body(source, neutral)[:2])


def upper_body(
    source: Source, vertices: Array, box: tuple[float, float, float] = BOX
) -> tuple[csr_matrix, Integers, Integers]:
    """(V, S) map to the fine surface, its (F, 3) triangles, and what its vertices but the lids' are called in the
    twice subdivided mesh, ascending; the (S, 3) m vertices decide where the box cuts."""
    first, quads = subdivide(source.quads, len(vertices))
    second, quads = subdivide(quads, first.shape[0])
    fine = second @ first
    place = np.asarray(fine @ vertices)
    kept = (place[:, 1] > box[0]) & (place[:, 1] < box[1]) & (np.abs(place[:, 0]) < box[2])
    quads = quads[kept[quads].all(axis=1)]
    used, renumbered = np.unique(quads, return_inverse=True)
    quads = renumbered.reshape(-1, 4)
    faces = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    faces, piece = _largest_piece(faces, len(used))  # the mouth's inside and fingertips fall off
    used = used[piece]
    fine, faces = _closed(fine[used], faces)
    return fine, faces, used


def _largest_piece(faces: Integers, count: int) -> tuple[Integers, Integers]:
    links = csr_matrix((np.ones(faces.size), (faces.ravel(), np.roll(faces, 1, axis=1).ravel())), (count, count))
    _, label = connected_components(links, directed=False)
    piece = np.bincount(label[faces[:, 0]]).argmax()
    used, renumbered = np.unique(faces[label[faces[:, 0]] == piece], return_inverse=True)
    return renumbered.reshape(-1, 3), used


def _closed(fine: csr_matrix, faces: Integers) -> tuple[csr_matrix, Integers]:
    """With a lid over each opening, so that no camera looks into the body."""
    for loop in boundary_loops(faces):
        middle = np.full(len(loop), fine.shape[0])
        fine = vstack([fine, csr_matrix(fine[loop].mean(axis=0))]).tocsr()
        faces = np.concatenate([faces, np.stack([np.roll(loop, -1), loop, middle], axis=1)])
    return fine, faces


def side_mask(x: Array, side: str) -> Array:
    """1 on one side of the body, 0 on the other, smooth over 6 cm in the middle."""
    share = np.clip((x if side == "L" else -x) / 0.06 + 0.5, 0.0, 1.0)
    return share * share * (3.0 - 2.0 * share)


def _figure(source: Source) -> Array:
    """(S, 3) m: what makes this woman of MakeHuman's androgynous base."""
    ages = {"young": YOUNG, "old": 1.0 - YOUNG}
    result = np.zeros_like(source.vertices)
    for age, share in ages.items():
        for origin in ("african", "asian", "caucasian"):
            result += share / 3.0 * source.target(f"macrodetails/{origin}-female-{age}")
        for weight, part in MUSCLE_WEIGHT.items():
            result += share * part * source.target(f"macrodetails/universal-female-{age}-averagemuscle-{weight}")
    for side in ("L", "R"):
        mask = side_mask(source.vertices[:, 0], side)[:, None]
        cup, soft = CUP[side], SOFTNESS[side]
        for age, share in ages.items():
            kinds = {
                "maxcup-averagefirmness": cup * (1.0 - soft),
                "averagecup-minfirmness": (1.0 - cup) * soft,
                "maxcup-minfirmness": cup * soft,
            }
            for kind, part in kinds.items():
                name = f"breast/female-{age}-averagemuscle-averageweight-{kind}"
                result += share * part * mask * source.target(name)
    result += side_mask(source.vertices[:, 0], "L")[:, None] * 0.25 * source.target("breast/breast-trans-down")
    for name, part in EXTRA:
        result += part * source.target(name)
    return result


def _posed(source: Source, vertices: Array, turns: Turns) -> tuple[Array, dict[str, Array]]:
    """Linear blend skinning with MakeHuman's weights along chest, collar, shoulder blade and arm."""
    identity = (np.eye(3), np.zeros(3))
    chest = _turned(identity, source.joint("spine-3", vertices), _about(2, -turns.lean))
    parts = [(chest, _weight(source, CHEST, ""))]
    shoulders = {}
    for side, sign in (("L", 1.0), ("R", -1.0)):
        lower = side.lower()
        up, back = turns.collar[side]
        collar = _turned(
            chest, source.joint(f"{lower}-clavicle", vertices), _about(2, sign * up) @ _about(1, sign * back)
        )
        blade = _turned(collar, source.joint(f"{lower}-scapula", vertices), _about(2, sign * turns.blade[side]))
        raised, backwards = turns.arm[side]
        shoulder = source.joint(f"{lower}-shoulder", vertices)
        arm = _turned(blade, shoulder, _about(1, sign * backwards) @ _about(2, sign * raised))
        shoulders[side] = blade[0] @ shoulder + blade[1]
        parts += [(collar, _weight(source, ("clavicle",), side))]
        parts += [(blade, _weight(source, ("shoulder01",), side))]
        if turns.elbow is None:
            parts += [(arm, _weight(source, ARM, side))]
            continue
        raised, backwards = turns.elbow
        elbow = source.joint(f"{lower}-elbow", vertices)
        forearm = _turned(arm, elbow, _about(1, sign * backwards) @ _about(2, sign * raised))
        parts += [(arm, _weight(source, ("upperarm",), side)), (forearm, _weight(source, FOREARM, side))]
    rest = 1.0 - sum(weight for _, weight in parts)
    result = rest[:, None] * vertices
    for (linear, offset), weight in parts:
        result += weight[:, None] * (vertices @ linear.T + offset)
    return result, shoulders


def _weight(source: Source, prefixes: tuple[str, ...], side: str) -> Array:
    """(S,) summed skin weight of the bones that begin so, of one side or of both."""
    result = np.zeros(len(source.vertices))
    for bone, (index, value) in source.weights.items():
        if bone.startswith(prefixes) and (not side or bone.endswith("." + side)):
            result[index] += value
    return result


def _turned(above: tuple[Array, Array], joint: Array, turn: Array) -> tuple[Array, Array]:
    """The affine map of a part that turns around its joint and follows the part above."""
    linear, offset = above
    return linear @ turn, linear @ (joint - turn @ joint) + offset


def _about(axis: int, degrees: float) -> Array:
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    i, j = (axis + 1) % 3, (axis + 2) % 3
    result = np.eye(3)
    result[i, i] = result[j, j] = c
    result[i, j], result[j, i] = -s, s
    return result
