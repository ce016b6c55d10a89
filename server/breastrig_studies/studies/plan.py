"""Assigns questions to cases.

Two rounds: the number of blendshapes is studied in the order of their usefulness, which the first round measures.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path

from breastrig.core.stances import PRONE
from breastrig.fitting.recipe import Recipe
from breastrig.rig.model import Rig
from breastrig_studies.cohort import Case
from breastrig_studies.studies.lesions import FILE as LESIONS
from breastrig_studies.studies.result_cache import Record, Unit
from breastrig_studies.studies.sensitivity import TERMS

FACTORS = (0.01, 0.1, 1.0, 10.0, 100.0)  # decades around the preset's own compliance
COUNT_STEP = 5  # blendshapes added at a time
ORDERS = ("usefulness", "rig")


@dataclass(frozen=True, eq=False)
class Plan:
    """The questions, cases and settings of an evaluation."""

    cases: tuple[Case, ...]
    recipes: tuple[Recipe, ...]  # the first one is studied, the others stand beside it
    model: Path
    rotations: int
    quick: bool
    test: bool = False  # what is asked of the test set, and nothing else

    @property
    def plain(self) -> tuple[Case, ...]:
        """The cases whose shape is measured."""
        return tuple(case for case in self.cases if not case.coloured)

    def _each(self, question: str, recipe: Recipe | None = None, **settings: object) -> list[Unit]:
        chosen = recipe or self.recipes[0]
        return [Unit((case,), question, chosen, self.model, dict(settings)) for case in self.plain]

    def first_round(self) -> list[Unit]:
        """Everything but the number of blendshapes."""
        if self.test:
            return self._each("asked")
        units = [unit for recipe in self.recipes for unit in self._each("accuracy", recipe)]
        for question in ("halves", "no_landmarks", "clicks", "one_wrong", "exchanged_sides"):
            units += self._each(question)
        units += [unit for unit in self._each("prone") if unit.cases[0].stance == PRONE]
        if self.rotations:
            units += self._each("random_turns", rotations=self.rotations)
        if not self.quick:
            units += self._each("unseen") + self._each("certainty") + self._each("measures") + self._each("verdicts")
            for method in ("rigid", "nricp_amberg"):
                units += self._each("peer", method=method)
            for recipe in self.recipes:
                for term, factor in compliances():
                    units += self._each("compliance", recipe, term=term, factor=factor)
            units += self._pairs_of_stances() + self._pairs_of_patients()
        units += self._of_colour()
        place = {case: k for k, case in enumerate(self.cases)}
        return sorted(units, key=lambda unit: place[unit.cases[0]])  # by case, whose scan is then read once

    def _of_colour(self) -> list[Unit]:
        """The questions to coloured cases, and to the stances of one patient."""
        coloured = [case for case in self.cases if case.coloured]
        units = [
            Unit((case,), question, self.recipes[0], self.model)
            for case in coloured
            for question in ("colour_landmarks", "ink")
        ]
        for _, group in groupby(coloured, lambda case: case.patient):
            cases = tuple(group)
            if {case.stance for case in cases} >= {"standing", "supine"}:
                units.append(Unit(cases, "ink_transfer", self.recipes[0], self.model))
        return units

    def _pairs_of_stances(self) -> list[Unit]:
        units = []
        for _, group in groupby(self.plain, lambda case: case.patient):
            cases = tuple(group)
            if {case.stance for case in cases} >= {"standing", "supine"}:
                units += [Unit(cases, question, self.recipes[0], self.model) for question in ("transfer", "prediction")]
            if (cases[0].folder.parent / LESIONS).is_file():
                units.append(Unit(cases, "lesions", self.recipes[0], self.model))
        return units

    def _pairs_of_patients(self) -> list[Unit]:
        """Each patient with the next one of the same family in the same setting, the last with the first."""
        units = []
        for setting in dict.fromkeys((case.family, case.name) for case in self.plain):
            same = [case for case in self.plain if (case.family, case.name) == setting]
            if len(same) > 1:
                for first, second in zip(same, [*same[1:], same[0]], strict=True):
                    units.append(Unit((first, second), "other_patient", self.recipes[0], self.model))
        return units

    def second_round(self, rig: Rig, useful: dict[str, tuple[str, ...]]) -> list[Unit]:
        """The number of blendshapes in both orders; `useful` names the shapes of each setting, best first."""
        units = {}
        for case in () if self.quick else self.plain:
            for order in ORDERS:
                for count in counts(len(rig.shapes)):
                    names = first_shapes(rig, useful[case.name], order, count)
                    units[case, names] = Unit((case,), "shape_count", self.recipes[0], self.model, {"names": names})
        return list(units.values())


def compliances() -> list[tuple[str, float]]:
    """Each term at each factor; factor 1 is the same for all and stands once."""
    return [(TERMS[0], 1.0), *((term, factor) for term in TERMS for factor in FACTORS if factor != 1.0)]


def counts(shapes: int) -> list[int]:
    """0, 5, ... and all shapes."""
    return [*range(0, shapes, COUNT_STEP), shapes]


def first_shapes(rig: Rig, useful: Sequence[str], order: str, count: int) -> tuple[str, ...]:
    """The first `count` shapes of an order, in the rig's order: the order does not change a fit."""
    chosen = set((useful if order == "usefulness" else rig.shape_names)[:count])
    return tuple(name for name in rig.shape_names if name in chosen)


def shape_effects(records: Sequence[Record], rig: Rig) -> dict[str, dict[str, float]]:
    """For each setting, by how many mm each shape moved the skin on average over the fits (0 where none was)."""
    effects: dict[str, dict[str, float]] = {}
    for setting in sorted({record.case.name for record in records}):
        fits = [
            record.answer["shape_effect_mm"] for record in records if record.case.name == setting and not record.failed
        ]
        mean = {name: sum(fit[name] for fit in fits) / max(len(fits), 1) for name in rig.shape_names}
        effects[setting] = dict(sorted(mean.items(), key=lambda item: -item[1]))
    return effects
