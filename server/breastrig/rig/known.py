"""Data estimated for a rig, by file name: priors, limits, expected errors. Any of it may be missing.

The files are in the folder NAME.known beside NAME.glb and are bound to the rig by its hash (gltf/known_files.py), so
that what was measured with one rig is never said of another.

    bodies.json          mean and covariance of scales and shapes over bodies       rig/body_statistics.py
    priors_STANCE.toml   shapes and joints where a stance differs from the rig     rig/stance_priors.py
    modes.toml           smooth modes of what the shapes do not show                rig/modes.py
    landmark_errors.json  landmarks of bodies beside the model's                    fitting/body/landmarks.py
    hidden_STANCE.json   depth of skin that no scan shows                           fitting/body/refine.py
    trunk_depth.json     its additional depth under a high belly                    fitting/body/refine.py
    lying_motion.json    motion of the skin between standing and supine             drawings/skin_maps/lying_motion.py
    gravity.json         effect of gravity on breasts in all stances                volume/predicted.py
    skin_map.toml        differences from the common settings of the skin map       drawings/skin_maps/settings.py
    radii.json           distance of bodies from the model beyond a fit's own error fitting/uncertainty/radii.py
    uncertainty.toml     effect of picks that scatter, and of an unclear start      fitting/uncertainty/radii.py
    verdict.toml         limits of right fits                                       fitting/verdicts/verdict.py
    same_body.toml       difference between two fits of one body                    use/folder/one_body.py
    measures.toml        errors of measures; visits.toml: between dates              report/calibration.py, visits/
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
    """The document of one of these files; None where it is missing. Raises BadModel for a damaged one."""
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
    """The rig's data of this file, validated as `kind`; None where there are none."""
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
