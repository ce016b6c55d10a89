"""The model as programs load it."""

from dataclasses import fields
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from breastrig.core.arrays import Array
from breastrig.core.assets import model_path
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig import model
from breastrig.rig.cohort_prior import read_prior, with_prior
from breastrig.rig.named_parameters import Parameters, posed, sampled

if TYPE_CHECKING:
    from PIL.Image import Image


class Rig(model.Rig):
    """A rigged model that can be posed and sampled by name."""

    def pose(self, parameters: Parameters) -> Array:
        """(V, 3) the skin in this pose and shape, in the parameters' unit and frame; with `fit.parameters` the fit's.

        Parameters are changed with dataclasses.replace.  Raises BadSettings for those of another rig.
        """
        return posed(self, parameters)

    def sample(self, rng: np.random.Generator) -> Parameters:
        """A body drawn by what is known of bodies (or by the shapes' sigmas), its joints turned; in metres.

        The joints hold, limits are kept, the root bone is at rest.
        """
        return sampled(self, rng)

    def picture(
        self,
        vertices: ArrayLike,
        *,
        unit: str = "m",
        view: str = "front",
        colours: ArrayLike | None = None,
        size: tuple[int, int] = (300, 360),
    ) -> "Image":
        """A picture of a body of this model, without a display.

        Args:
            vertices: (V, 3) in `unit`.
            unit: m, dm, cm, mm, in or ft.
            view: As in `Fit.picture`.
            colours: (V, 3) red, green and blue, 0 to 1; None: grey.
            size: Width and height in pixels.

        Raises:
            BadSettings: For another view.
        """
        from breastrig.use.values.picture import body_picture  # rendering, which other programs need not load

        return body_picture(self, np.asarray(vertices), unit, view, colours, size)


Model = model.Rig | str | Path | None  # loaded, its .glb, a packaged one's name, or None for the torso of the package


def load_model(path: str | Path | None = None) -> Rig:
    """The rigged model of a .glb with its side file (.json) beside it; "male" is the package's chest of a man.

    Without a path it is the torso of the package, a woman's.

    Its arrays are in metres in the body frame (+X to the patient's left, +Y to the head, +Z to the front): template
    (V, 3), faces (F, 3), blendshapes (S, V, 3); it names its bones, shapes and landmarks.  Loading takes some tens of
    milliseconds: load once and hand it to `fit` when there are many scans.

    Raises BadModel with one sentence.
    """
    return public(read_rig(default_rig_path() if path is None else model_path(path)))


def public(rig: model.Rig) -> Rig:
    """The model as a public `Rig`."""
    return rig if isinstance(rig, Rig) else _public(rig)


@lru_cache(maxsize=4)
def _public(rig: model.Rig) -> Rig:
    """The model as a public `Rig`, the same object each time: derived data are cached with it."""
    return Rig(**{each.name: getattr(rig, each.name) for each in fields(rig)})


def loaded(given: Model) -> Rig:
    """The model itself, loaded where it is not yet."""
    return public(given) if isinstance(given, model.Rig) else load_model(given)


def with_cohort(given: Model, prior: str | Path | None) -> Rig:
    """The model with which a cohort's prior is known; BadInput for a file that is none, or another model's."""
    if prior is None:
        return loaded(given)
    if not isinstance(given, model.Rig):
        given = read_rig(default_rig_path() if given is None else model_path(given))  # the same object each time
    return public(with_prior(given, read_prior(Path(prior))))


def files_of(given: Model, prior: str | Path | None = None) -> tuple[Path, ...]:
    """The .glb and its side file, where the model was given as a file, and the prior's."""
    own = (model_path(given), model_path(given).with_suffix(".json")) if isinstance(given, str | Path) else ()
    return own if prior is None else (*own, Path(prior))
