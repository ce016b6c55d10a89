"""`moving_picture.py FRAMES.json OUT.webp`: pictures, [{"file", "ms"}], as one that moves; one alone as it is."""

import json
import sys
from pathlib import Path

from PIL import Image

SIZE = (960, 540)  # pixels: as wide as a README is shown
QUALITY = 55  # of 100
STILL = 82  # of 100: words of 12 pixels stay sharp

if __name__ == "__main__":
    frames = json.loads(Path(sys.argv[1]).read_text("utf-8"))
    pictures = [Image.open(each["file"]).convert("RGB") for each in frames]
    if len(pictures) == 1:
        pictures[0].save(sys.argv[2], quality=STILL, method=6)
    else:
        small = [each.resize(SIZE, Image.Resampling.LANCZOS) for each in pictures]
        durations = [each["ms"] for each in frames]
        small[0].save(
            sys.argv[2], save_all=True, append_images=small[1:], duration=durations, loop=0, quality=QUALITY, method=6
        )
