"""First fit.

Reads a scan with its landmarks, fits the model, prints the verdict and how sure it is, saves the fit and
loads it again. The picture shows the scan beside the model, coloured by its distance to the scan.
"""

import tempfile

from PIL import Image

import breastrig


def main() -> Image.Image:
    example = breastrig.example("standing")
    scan = breastrig.read_scan(example.scan)
    print(scan, scan.unit_reason)

    fit = breastrig.fit(scan, example.landmarks)
    print(fit, *fit.verdict.reasons)
    print(f"lines on the breasts: ± {fit.line_error_mm:.1f} mm (90 %)")
    for name, radius in fit.landmark_radii.items():
        print(f"  {name:22s} ± {1e3 * fit.metres_per_unit * radius:4.1f} mm")

    with tempfile.TemporaryDirectory() as folder:
        fit.save(folder)  # what `breastrig fit -o FOLDER` writes
        print("loaded again:", breastrig.Fit.load(folder))

    picture = Image.new("RGB", (960, 560))
    picture.paste(fit.picture(show="scan"), (0, 0))
    picture.paste(fit.picture(show="distances", drawing=fit.drawing), (480, 0))
    return picture


if __name__ == "__main__":
    main().save("first_fit.png")
