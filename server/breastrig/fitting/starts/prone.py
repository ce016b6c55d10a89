"""Where a prone body starts without landmarks: on what its hanging breasts show (relief/prone.py), the head on either
side; each is fitted for two stages, and the one with the least energy goes on (docs/decisions/0019)."""

from collections.abc import Sequence

import numpy as np

from breastrig.core.arrays import Array
from breastrig.core.stances import PRONE
from breastrig.correspondence.target import ScanTarget
from breastrig.fitting.starts.hypotheses import ranked
from breastrig.fitting.starts.orientation import Start
from breastrig.relief.prone import ProneView, prone_views
from breastrig.rig.model import Rig
from breastrig.rig.similarity import Similarity
from breastrig.rig.stance_priors import mean_weights
from breastrig.scan.orient import Frame

HIGH, WIDE = 0.38, 0.46  # m: skins of MRIs are 0.14 to 0.32 high and 0.28 to 0.42 wide, others 0.47 and 0.43 or more
IN_FRONT = 0.03  # m, of nipples before the xiphoid; 0.035 to 0.1 prone, 0.005 to 0.034 standing
CLEFT, BESIDE, ALONG = 0.045, 0.01, 0.03  # m, of nipples before the skin between them, which is this narrow and long
FIELD = 2.0  # nipples are 0.28 to 0.5 of the way from the lower to the upper end, 0.66 to 0.85 the other way round
USUAL_SCALE = 1.05  # of the trunk; hanging breasts say nothing of it


def prone_start(rig: Rig, target: ScanTarget, frame: Frame, views: Sequence[ProneView] | None = None) -> Start | None:
    """For a scan of this frame, whose way up counts where it is certain; None where it shows no two breasts."""
    seen = list(prone_views(target.vertices, target.faces, frame.front)) if views is None else views
    if frame.confidence == 1.0:
        seen = [view for view in seen if view.axes[:, 1] @ frame.up > 0.0]
    openings = ranked(
        rig, target, [_placed(rig, each) for each in seen], PRONE, [_field(target, each) for each in seen]
    )
    tried = [each for each in openings if np.isfinite(each.energy)]
    if not tried or tried[0].place is None:
        return None
    best, *others = tried
    margin = others[0].price * others[0].energy / (best.price * best.energy) - 1.0 if others else 1.0
    return Start(rig, tried[0].place, margin, best)


def _placed(rig: Rig, view: ProneView) -> Similarity:
    """The rest pose with the stance's breasts on the view's landmarks."""
    body = rig.template + np.tensordot(mean_weights(rig, PRONE), rig.blendshapes, axes=1)
    names = tuple(name for name in view.places if name in rig.landmark_names)
    model = rig.landmark_points(names).positions(body, rig.faces).mean(axis=0)
    seen = np.mean([view.places[name] for name in names], axis=0)
    return Similarity(USUAL_SCALE, view.axes, seen - USUAL_SCALE * view.axes @ model)


def _field(target: ScanTarget, view: ProneView) -> float:
    """What the field of view makes of an energy: of the skin that an MRI shows most is above the nipples."""
    up = view.axes[:, 1]
    low, high = np.percentile(target.vertices @ up, [1.0, 99.0])
    nipples = 0.5 * (view.places["nipple_L"] + view.places["nipple_R"]) @ up
    return float(np.exp(FIELD * (nipples - low) / max(high - low, 1e-9)))


def hanging_views(target: ScanTarget, front: Array) -> list[ProneView]:
    """What a scan shows that is no larger than an MRI's field of view, with two breasts and the skin between them
    behind; nothing of others."""
    flat = target.vertices - np.outer(target.vertices @ front, front)
    flat -= flat.mean(axis=0)
    across = flat @ np.linalg.eigh(flat.T @ flat)[1][:, 1:]  # (V, 2) m
    shorter, longer = np.sort(np.ptp(np.percentile(across, [1.0, 99.0], axis=0), axis=0))
    if shorter > HIGH or longer > WIDE or len(across) == 0:
        return []
    views = list(prone_views(target.vertices, target.faces, front))
    return views if any(_hangs(target, view) for view in views) else []


def _hangs(target: ScanTarget, view: ProneView) -> bool:
    """Whether the nipples are far before the skin between them, and before the xiphoid where that is seen."""
    nipples = 0.5 * (view.places["nipple_L"] + view.places["nipple_R"])
    away = (target.vertices - nipples) @ view.axes
    between = away[(np.abs(away[:, 0]) < BESIDE) & (np.abs(away[:, 1]) < ALONG), 2]
    if not len(between) or -np.quantile(between, 0.1) < CLEFT:
        return False
    return "xiphoid" not in view.places or bool((nipples - view.places["xiphoid"]) @ view.axes[:, 2] > IN_FRONT)
