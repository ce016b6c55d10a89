"""Verdicts on scans without a table, given as users do: all landmarks, none, a wrong one, or a wrong size.

The stance is `auto`. A fit is right when its landmarks are off by no more than RIGHT on average.
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from breastrig.core.arrays import Array
from breastrig.core.clock import Clock
from breastrig.core.errors import FitFailed
from breastrig.fitting.hypotheses import UNCLEAR
from breastrig.fitting.recipe import Recipe
from breastrig.rig.model import Rig
from breastrig.scan.scan import Scan
from breastrig.use.fit import fit_steps
from breastrig.use.steps.outcome import FitOutcome
from breastrig.use.steps.prepare import fit_plan, prepare_fit
from breastrig.use.steps.settings import FitSettings
from breastrig_studies.studies.case import Scene

RIGHT = 15.0  # mm
ASTRAY = 0.03  # m, how far the wrong pick lies along the skin
LARGER = 1.25  # times its true size, a scan of photogrammetry
BREAST = ("nipple", "inframammary_fold", "xiphoid")  # of which one is picked wrongly


def asked(scene: Scene, rig: Rig, recipe: Recipe) -> dict[str, Any]:
    """{kind: {"level": a verdict's or "refused", "reasons", "error_mm", "stance", "unclear"}}."""
    random, true = np.random.default_rng(len(scene.target.vertices)), dict(scene.landmarks)
    name = random.choice([each for each in true if each.startswith(BREAST)])
    wrong = true | {name: scene.along_the_skin(true[name], ASTRAY, random)}
    return {
        "all": answer(scene, rig, recipe, true),
        "none": answer(scene, rig, recipe, {}),
        "one_wrong": answer(scene, rig, recipe, wrong),
        "larger": answer(scene, rig, recipe, true, LARGER),
    }


def answer(scene: Scene, rig: Rig, recipe: Recipe, picks: Mapping[str, Array], scale: float = 1.0) -> dict[str, Any]:
    """The verdict of one fit; `picks` are (3,) m by name, scan and picks are `scale` times their size."""
    scan = Scan(scale * scene.target.vertices, scene.target.faces, "m", 1.0, "As asked for.", "0" * 64)
    given = {name: (1e3 * scale * place).tolist() for name, place in picks.items()}
    plan = replace(fit_plan(FitSettings(drawing=None, refine=False), rig, given), recipe=recipe)
    clock = Clock()
    try:
        *_, last = fit_steps(prepare_fit(plan, scan, clock), clock)
    except FitFailed as failed:
        return {"level": "refused", "reasons": [str(failed)]}
    assert isinstance(last, FitOutcome)
    errors = scene.landmark_errors(rig, last.vertices / scale)
    return {
        "level": last.verdict.level,
        "reasons": list(last.verdict.reasons),
        "error_mm": round(1e3 * float(errors.mean()), 2),
        "stance": last.ready.hypothesis.task.stance,
        "unclear": last.ready.hypothesis.stance_reason in UNCLEAR,
    }
