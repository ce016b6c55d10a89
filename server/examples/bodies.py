"""Bodies drawn at random.

What the model knows of bodies before it sees a scan: ten bodies drawn from the prior, posed by name.
"""

import numpy as np
from PIL import Image

import breastrig


def main() -> Image.Image:
    model = breastrig.load_model()
    rng = np.random.default_rng(3)
    picture = Image.new("RGB", (1000, 480))
    for place in range(10):
        parameters = model.sample(rng)
        body = model.pose(parameters)  # (V, 3) m
        height, width = np.ptp(body[:, 1]), np.ptp(body[:, 0])
        print(f"body {place}: {1e3 * height:.0f} mm high, {1e3 * width:.0f} mm wide")
        picture.paste(
            model.picture(body, view="three_quarter", size=(200, 240)), (200 * (place % 5), 240 * (place // 5))
        )
    return picture


if __name__ == "__main__":
    main().save("bodies.png")
