from pathlib import Path

import numpy as np
from PIL import Image
from sheets import contact_sheet, save_png


def test_pictures_are_saved_and_laid_side_by_side(tmp_path: Path) -> None:
    pictures = [np.full((20, 30, 3), value, dtype=np.uint8) for value in (10, 120, 240)]
    sheet = contact_sheet(pictures, columns=2, labels=("", "b"))
    assert sheet.shape == (40, 60, 3)
    assert list(sheet[[5, 35, 35], [5, 5, 55], 0]) == [10, 240, 255]
    save_png(sheet, tmp_path / "sheet.png")
    with Image.open(tmp_path / "sheet.png") as image:
        assert image.size == (60, 40)
