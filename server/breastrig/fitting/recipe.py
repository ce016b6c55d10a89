"""A fit's settings as data: stages, priors, stop rule, outliers. Preset files are TOML beside this module.

Every expected size (sigma) has a unit; the paper's compliance λ of a term is its σ² (equations 8 and 9). A pair [start,
end] is run through geometrically while the stage tightens.
"""

import tomllib
from collections.abc import Mapping
from functools import lru_cache
from importlib import resources
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, ValidationError, model_validator

from breastrig.core.errors import BadSettings, unknown_name
from breastrig.core.private_files import is_ordinary, shown
from breastrig.core.settings_file import Positive, SettingsPart


def preset_names() -> tuple[str, ...]:
    """The presets that ship with the package."""
    folder = resources.files("breastrig.fitting") / "presets"
    return tuple(sorted(Path(str(item)).stem for item in folder.iterdir() if item.name.endswith(".toml")))


def preset_text(name: str) -> str:
    """The file of a preset that ships with the package; BadSettings for another name."""
    if name not in preset_names():
        raise BadSettings(unknown_name("preset", shown(name), preset_names()))
    return (resources.files("breastrig.fitting") / "presets" / f"{name}.toml").read_text("utf-8")


def changed(base: Mapping[str, Any], given: Mapping[str, Any]) -> dict[str, Any]:
    """The base with the given values in place of its own; tables are merged, stages by their names."""
    result = dict(base)
    for name, part in given.items():
        old = result.get(name)
        if isinstance(part, Mapping) and isinstance(old, Mapping):
            result[name] = changed(old, part)
        elif isinstance(part, Mapping) and isinstance(old, list):
            stages = {stage["name"]: stage for stage in old}
            unknown = next((stage for stage in part if stage not in stages), None)
            if unknown is not None:
                raise BadSettings(unknown_name("stage of the base", str(unknown), tuple(stages)))
            result[name] = [changed(stage, part.get(key, {})) for key, stage in stages.items()]
        else:
            result[name] = part
    return result


COMMON = "default"  # what a preset is silent about is taken from it:
COMMON_PARTS = ("outliers", "lying", "partners")

Range = tuple[Positive, Positive]


class Stop(SettingsPart):
    distance_change_m: Positive  # converged when the mean distance changes by less than this
    patience: Annotated[int, Field(ge=1)]  # so many iterations in a row


class Observations(SettingsPart):
    spacing: Positive  # m on the skin between observations that tell something new of each other
    focus: tuple[str, ...] = ()  # regions of the rig, where it is narrower; those that the rig lacks are left out
    focus_spacing: Positive = 1.0  # m, in these regions, at most `spacing`
    growth: Annotated[float, Field(ge=0.0)] = 0.0  # of the spacing, m for each m of distance from the regions


class Joints(SettingsPart):
    rotation_sigma: Positive | None = None  # rad, the same for all joints; else the rig's own
    translation_sigma: Positive | None = None  # m; else the rig's own
    rotation_factor: Positive = 1.0
    translation_factor: Annotated[float, Field(ge=0.0)] = 1.0
    limit_sigma: Positive | None = None  # rad, how softly the rig's limits are met; absent: no limits


class Scales(SettingsPart):
    sigma: Positive
    neighbour_sigma: Positive | None = None
    symmetry_sigma: Positive | None = None


class Body(SettingsPart):
    """Weight of the statistics of bodies; see fitting/body and energies/body_prior.py."""

    share: Positive  # of their covariance
    scale_sigma: Positive  # what single scales do beyond it
    shape_factor: Positive  # likewise single weights, in units of what is expected of them (Shapes)


class Folding(SettingsPart):
    """Limits on skin that shapes press together; see energies/folding.py."""

    least: Annotated[float, Field(lt=1.0)]  # stretch of an edge along itself
    sigma: Positive  # of that stretch


class Shapes(SettingsPart):
    sigma: Positive | None = None  # the same for all shapes; else the rig's own times the factor
    factor: Positive = 1.0
    symmetry_sigma: Positive | None = None  # in each shape's own sigmas
    standing_gravity_factor: Positive = 1.0  # sigma of gravity shapes in a standing scan
    supine_gravity_mean: float = 0.0  # expected weight of gravity shapes in a supine scan
    folding: Folding | None = None  # absent: the skin may fold


class Observed(SettingsPart):
    """Expected errors of what is observed; a stage counts all of them times its temperature."""

    skin: Positive  # m, between a vertex of a well fitted model and the scan
    skin_outlier: Positive | None = None  # so many of them off a match is as likely none; absent: all count alike
    farthest: Positive  # m, farther off there is no match
    landmark: Positive  # m on each axis, of a pick
    form: Positive = 1.0  # times the errors of landmarks that the skin's form shows


class Stage(SettingsPart):
    name: str
    iterations: Annotated[int, Field(ge=1, le=500)]  # at most
    tighten: Annotated[int, Field(ge=1, le=500)]  # iterations until the temperature is at its end; then it may converge
    temperature: Range = (1.0, 1.0)  # of all observations: their errors count so many times
    method: Literal["rays", "tree", "nearest_vertex"]
    every: Annotated[int, Field(ge=1, le=20)] = 1  # match every so-manieth vertex only
    max_angle: Positive  # rad
    reject_border: bool = True
    data_term: Literal["point_to_plane", "point_to_projection"] = "point_to_plane"
    along: Positive | None = None  # times the skin's error: point to point beside point to plane; absent: slide freely
    free_shapes: tuple[Literal["body", "soft", "gravity"], ...] = ("body", "soft", "gravity")
    free_scales: bool = True
    free_modes: bool = False  # those of the rig (rig/modes.py)
    doubts_picks: bool = False  # a pick far off may be thrown out
    looks_at_form: bool = False  # for landmarks that nobody picked

    @model_validator(mode="after")
    def _one_data_term(self) -> "Stage":
        if self.data_term != "point_to_plane" and self.along is not None:
            raise ValueError(f"along stands beside point_to_plane only, not beside {self.data_term}")
        return self


class Outliers(SettingsPart):
    """Limits beyond which a picked landmark is questioned or rejected; see fitting/picks."""

    unusual: Positive  # standard deviations from where it is expected, beyond which a pick is asked about
    most: Annotated[float, Field(ge=0.0, lt=1.0)]  # share of the picks that may be rejected
    slip: Annotated[float, Field(gt=0.0, lt=0.5)]  # share of picks whose side, landmark or place was not meant, each
    sure: Annotated[float, Field(gt=0.5, lt=1.0)]  # chance of another meaning beyond which picks are not followed
    skin: Positive  # m², on which a pick may lie that was not meant for any landmark
    facing: Positive  # concentration of the skin's normals about the template's (von Mises and Fisher)
    template: Positive  # m on each axis, of bodies' landmarks from those of the template in their place and size

    @property
    def anywhere(self) -> float:
        """1/m², the density of picks that were not meant for any landmark."""
        return self.slip / self.skin


class Lying(SettingsPart):
    """Contact of a back with a table that the scan shows; see energies/table_contact.py."""

    sigma: Positive  # m, of the height of the whole back
    profile_sigma: Positive  # m, of each bone's part against the whole
    floor_sigma: Positive  # m, how softly the table is met from above
    reach: Positive  # m; a plane that is farther off than this at the start is a wall, or the patient is raised from it
    heights: dict[str, float]  # m, expected mean height of the back above the table, by bone


class Hanging(SettingsPart):
    """Conditions for a second start with hanging breasts; see body/hanging_start.py."""

    after: str  # the stage that shows whether they were flattened
    least: Annotated[float, Field(gt=0.0, lt=1.0)]  # share of the skin in front that faces down without the model
    shape: str  # that lets a breast hang, without its side
    weight: float  # of it, at the second start, and expected from there on
    sigma: Positive  # of that expectation


class Recipe(SettingsPart):
    name: str
    description: str
    damping: Positive  # in units of the priors' information
    stop: Stop
    observed: Observed
    observations: Observations | None = None  # absent: each vertex of the model is one observation
    joints: Joints
    scales: Scales
    shapes: Shapes
    body: Body | None = None  # absent: scales and shapes do not know of each other
    outliers: Outliers
    lying: Lying
    hanging: Hanging | None = None  # absent: it begins once
    partners: dict[str, Positive]  # m on each axis, of a landmark from the other side's pick, by name without its side
    stages: Annotated[tuple[Stage, ...], Field(min_length=1)]

    @property
    def iterations_limit(self) -> int:
        return sum(stage.iterations for stage in self.stages)

    @property
    def continued(self) -> "Recipe":
        """For a start that is a fit already: without the first of several stages, which only brings the limbs over."""
        return self.model_copy(update={"stages": self.stages[1:] or self.stages})


def load_recipe(name_or_file: str | Path | Mapping[str, Any]) -> Recipe:
    """A preset by name, a TOML file of the same form, or such a document; BadSettings says what is wrong with it.

    With `base = "default"` only what differs is given: values of tables are put into those of the base, and `stages`
    may be a table by their names.  A document without a base changes the default.
    """
    if isinstance(name_or_file, Mapping):
        return _recipe({"base": COMMON} | dict(name_or_file), "of this program")
    if str(name_or_file) in preset_names():
        return _packaged(str(name_or_file))
    if Path(name_or_file).suffix == ".toml":
        if not is_ordinary(Path(name_or_file)):
            raise BadSettings(f"The preset {shown(name_or_file)} is not there or is no file; check the name.")
        try:
            return _recipe(tomllib.loads(Path(name_or_file).read_text("utf-8")), name_or_file)
        except tomllib.TOMLDecodeError as error:
            raise BadSettings(f"The preset {name_or_file} cannot be used: the file: {error}.") from error
        except (OSError, UnicodeDecodeError) as error:
            raise BadSettings(f"The preset {shown(name_or_file)} cannot be read; check the file.") from error
    raise BadSettings(unknown_name("preset", shown(name_or_file), preset_names()))


@lru_cache
def _packaged(name: str) -> Recipe:
    """Read once a process: TOML takes 8 ms, and each fit and proposal asks for it."""
    return _recipe(tomllib.loads(preset_text(name)), name)


def _recipe(given: dict[str, Any], name_or_file: str | Path) -> Recipe:
    base, given = given.get("base"), {name: part for name, part in given.items() if name != "base"}
    if base is not None:
        whole = tomllib.loads(preset_text(str(base)))
        given = changed(whole | {"name": f"{base}, changed"}, given)
    common = {name: part for name, part in tomllib.loads(preset_text(COMMON)).items() if name in COMMON_PARTS}
    try:
        return Recipe.model_validate(common | given)
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(map(str, first["loc"]))
        wrong = f"{where}: {first['msg']}."
        if first["type"] == "extra_forbidden":
            wrong = f"{where} is no setting; `breastrig presets show {COMMON}` prints the usual ones."
        raise BadSettings(f"The preset {name_or_file} cannot be used: {wrong}") from error
