"""Pictures that need no rays, for tests of files that hold pictures: what is shown is a question of other tests."""

from typing import Any

import numpy as np
import pytest

from breastrig.rendering.picture import Picture, Scene


def blank_pictures(patch: pytest.MonkeyPatch) -> None:
    """From now on every picture that this process makes is white, of the size that is asked for."""

    def white(_scene: Scene, _view: Any, size: tuple[int, int] = (640, 640), *_: Any, **__: Any) -> Picture:
        return np.full((size[1], size[0], 3), 255, dtype=np.uint8)

    patch.setattr(Scene, "render", white)
