"""Sensitivity to settings: each compliance over decades (figures 7 and 8), and the number of blendshapes (5 and 6).

A compliance of the paper is the square of a preset's sigma, so a factor on the one is its root on the other. A rig with
fewer shapes is the same rig with the rest left out; its file stays as it is.
"""

from dataclasses import replace
from typing import Any

import numpy as np

from breastrig.fitting.recipe import Body, Joints, Recipe, Scales, Shapes
from breastrig.rig.model import Rig
from breastrig_studies.studies.case import Scene

TERMS = ("data", "landmarks", "scales", "shapes", "joints")
OBSERVED = {"data": "skin", "landmarks": "landmark"}  # terms by the setting of their expected error


def _scales(scales: Scales, root: float) -> Scales:
    neighbour = None if scales.neighbour_sigma is None else root * scales.neighbour_sigma
    return scales.model_copy(update={"sigma": root * scales.sigma, "neighbour_sigma": neighbour})


def _shapes(shapes: Shapes, root: float) -> Shapes:
    sigma = None if shapes.sigma is None else root * shapes.sigma
    return shapes.model_copy(update={"sigma": sigma, "factor": root * shapes.factor})


def _body(body: Body | None, root: float, scale_root: float) -> Body | None:
    """The body prior for changed compliances: one Gaussian of scales and shapes, so it changes with either.

    `factor` is part of the shapes.
    """
    if body is None:
        return None
    return body.model_copy(update={"share": root**2 * body.share, "scale_sigma": scale_root * body.scale_sigma})


def _joints(joints: Joints, root: float) -> Joints:
    rotation = None if joints.rotation_sigma is None else root * joints.rotation_sigma
    translation = None if joints.translation_sigma is None else root * joints.translation_sigma
    return joints.model_copy(
        update={
            "rotation_sigma": rotation,
            "translation_sigma": translation,
            "rotation_factor": root * joints.rotation_factor,
            "translation_factor": root * joints.translation_factor,
        }
    )


def scaled_compliance(recipe: Recipe, term: str, factor: float) -> Recipe:
    """The recipe with one term's compliance times `factor`."""
    root = float(np.sqrt(factor))
    if term in OBSERVED:
        size = root * float(getattr(recipe.observed, OBSERVED[term]))
        return recipe.model_copy(update={"observed": recipe.observed.model_copy(update={OBSERVED[term]: size})})
    if term == "scales":
        return recipe.model_copy(
            update={"scales": _scales(recipe.scales, root), "body": _body(recipe.body, root, root)}
        )
    if term == "shapes":
        body = _body(recipe.body, root, 1.0)
        return recipe.model_copy(update={"shapes": _shapes(recipe.shapes, root), "body": body})
    assert term == "joints"
    return recipe.model_copy(update={"joints": _joints(recipe.joints, root)})


def compliance(scene: Scene, rig: Rig, recipe: Recipe, term: str, factor: float) -> dict[str, Any]:
    """The fit with all landmarks and one compliance changed."""
    return scene.numbers(rig, scene.fitted(rig, scaled_compliance(recipe, term, factor), scene.landmarks).vertices)


def with_shapes(rig: Rig, names: tuple[str, ...]) -> Rig:
    """The rig with these shapes only; a shape whose partner is left out stands alone.

    No shapes at all are one shape that moves nothing, because the solver wants at least one unknown weight.
    """
    chosen = [rig.shape_names.index(name) for name in names] or [0]
    shapes = [rig.shapes[k] for k in chosen]
    alone = tuple(replace(shape, mirror=shape.mirror if shape.mirror in names else shape.name) for shape in shapes)
    return replace(rig, shapes=alone, blendshapes=rig.blendshapes[chosen] * float(len(names) > 0))


def shape_count(scene: Scene, rig: Rig, recipe: Recipe, names: list[str]) -> dict[str, Any]:
    """The fit with all landmarks and these shapes only, and its time."""
    fewer = with_shapes(rig, tuple(names))
    fit = scene.fitted(fewer, recipe, scene.landmarks)
    return scene.numbers(fewer, fit.vertices) | {"time_s": round(fit.seconds, 4)}
