"""An image as a scan: its skin, and what of its voxels is kept to be shown."""

from breastrig.core.stances import SUPINE
from breastrig.scan.images.image import ImageVolume, kept_image
from breastrig.scan.images.skin.skin_of_image import skin_of_image
from breastrig.scan.piece import Piece, Pieces, SeenLandmark
from breastrig.scan.volumes.label_map import BOTH, ONE_BREAST

NO_NIPPLES = "The image's header says supine: nipples are looked for in prone images only; place them."
FRAME = "Places are in the DICOM patient frame (LPS), mm; the skin was made from the image."


def image_pieces(image: ImageVolume) -> Pieces:
    """The skin in mm, LPS, with the image as it is kept.  Raises BadScan or TooLarge with a sentence."""
    skin = skin_of_image(image)
    width = float(skin.vertices[:, 0].max() - skin.vertices[:, 0].min()) if len(skin.vertices) else BOTH
    is_supine = image.stance == SUPINE
    narrow = (ONE_BREAST.format(width),) if width < BOTH else ()
    return Pieces(
        (Piece(skin.vertices, skin.faces),),
        notes=(FRAME, *narrow, *image.notes, *skin.notes, *([NO_NIPPLES] if is_supine else [])),
        unit="mm",
        image=kept_image(image),
        seen=tuple(
            SeenLandmark(f"nipple_{each.side}", each.place, each.radius_mm) for each in skin.nipples if not is_supine
        ),
        stance=image.stance,
    )
