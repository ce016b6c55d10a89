"""`moving_picture.py FRAMES.json OUT.webp`: pictures one after the other, [{"file", "ms"}], as one that moves."""

import json
import sys
from pathlib import Path

from PIL import Image

SIZE = (960, 540)  # pixels: as wide as a README is shown
QUALITY = 55  # of 100

if __name__ == "__main__":
    frames = json.loads(Path(sys.argv[1]).read_text("utf-8"))
    pictures = [Image.open(each["file"]).convert("RGB").resize(SIZE, Image.Resampling.LANCZOS) for each in frames]
    durations = [each["ms"] for each in frames]
    pictures[0].save(
        sys.argv[2], save_all=True, append_images=pictures[1:], duration=durations, loop=0, quality=QUALITY, method=6
    )
