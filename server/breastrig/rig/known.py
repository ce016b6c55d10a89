"""What has been estimated for a rig, by file name: priors, limits, expected errors.  Any of it may be missing.

The files are in the folder NAME.known beside NAME.glb and are bound to the rig by its hash (gltf/known_files.py), so
that what was measured with one rig is never said of another.

    bodies.json          mean and covariance of scales and shapes over bodies       rig/body_statistics.py
    priors_STANCE.toml   shapes and joints where a stance differs from the rig     rig/stance_priors.py
    landmark_errors.json  where bodies have landmarks beside the model's             fitting/body/landmark_errors.py
    hidden_STANCE.json   how deep skin lies that no scan shows                      fitting/body/hidden_skin.py
    trunk_depth.json     and how much deeper it lies under a high belly             fitting/body/trunk_depth.py
    lying_motion.json    how skin moves between standing and lying                  drawings/skin_maps/lying_motion.py
    gravity.json            what gravity does to breasts in all stances            volume/predicted.py
    skin_map.toml        what differs from the common settings of the skin map      drawings/skin_maps/settings.py
    radii.json           how far bodies are from the model beyond what a fit knows  fitting/uncertainty/calibration.py
    uncertainty.toml     what picks that scatter, and an unclear start, make of it  fitting/uncertainty/calibration.py
    verdict.toml         what right fits look like                                  fitting/verdicts/verdict.py
    same_body.toml       how much two fits of one body differ                      workflow/folder/one_body.py
    measures.toml        what measures of breasts are off                           report/calibration.py
    volume.json          chest wall and tetrahedra                                  volume/known_volume.py
"""

import json
import tomllib
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError

from breastrig.core.errors import BadModel
from breastrig.rig.model import Rig

Part = TypeVar("Part", bound=BaseModel)
NOT_CALIBRATED = "Not calibrated for this rig"  # wherever radii or a verdict would be


def known_numbers(rig: Rig, file: str) -> dict[str, Any] | None:
    """The document of one of the files above; None where nothing is known.  Raises BadModel for a damaged one."""
    text = rig.known.get(file)
    if text is None:
        return None
    try:
        found = tomllib.loads(text) if file.endswith(".toml") else json.loads(text)
    except (ValueError, RecursionError) as error:
        raise BadModel(f"{rig.name}.known/{file} cannot be read ({error}); mend it or take it away.") from error
    if not isinstance(found, dict):
        raise BadModel(f"{rig.name}.known/{file} is no table of values; mend it or take it away.")
    return found


def known_part(rig: Rig, file: str, kind: type[Part]) -> Part | None:
    """The same, checked."""
    found = known_numbers(rig, file)
    return None if found is None else checked_part(rig, file, kind, found)


def checked_part(rig: Rig, file: str, kind: type[Part], numbers: dict[str, Any]) -> Part:
    """Numbers as `kind`; BadModel says which of them is wrong."""
    try:
        return kind.model_validate(numbers)
    except ValidationError as error:
        first = error.errors(include_url=False, include_input=False)[0]
        where = ".".join(map(str, first["loc"]))
        raise BadModel(f"{rig.name}.known/{file} cannot be used: {where}: {first['msg']}.") from error
