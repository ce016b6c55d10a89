"""Pictures that cost little, for tests of files that hold pictures: what is shown is a question of other tests."""

from typing import Any

import numpy as np
import pytest

from breastrig.rendering.picture import Picture, Scene

COARSER = 4


def blank_pictures(patch: pytest.MonkeyPatch) -> None:
    """From now on every picture that this process makes is white, of the size that is asked for."""

    def white(_scene: Scene, _view: Any, size: tuple[int, int] = (640, 640), *_: Any, **__: Any) -> Picture:
        return np.full((size[1], size[0], 3), 255, dtype=np.uint8)

    patch.setattr(Scene, "render", white)


def coarse_pictures(patch: pytest.MonkeyPatch) -> None:
    """From now on every picture that this process makes is drawn with a sixteenth of the rays, and as large as ever."""
    render = Scene.render

    def coarse(scene: Scene, view: Any, size: tuple[int, int] = (640, 640), *more: Any, **named: Any) -> Picture:
        width, height = size
        drawn = render(scene, view, (-(-width // COARSER), -(-height // COARSER)), *more, **named)
        return drawn.repeat(COARSER, axis=0).repeat(COARSER, axis=1)[:height, :width]

    patch.setattr(Scene, "render", coarse)
