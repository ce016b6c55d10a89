"""The models that a service offers: its own, and beside the package's torso the package's others by name."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from breastrig.core.assets import packaged_models

FACT = "model"  # of a scan: the name of the model that it is fitted with; absent: the service's own


@dataclass(frozen=True)
class ModelChoice:
    """The offered models; picklable, for workers."""

    own: Path | None  # the .glb; None: the package's torso
    others: dict[str, Path] = field(default_factory=dict)

    def of(self, facts: Mapping[str, Any]) -> Path | None:
        """The model of a stored scan."""
        return self.others.get(facts.get(FACT, ""), self.own)


def model_choice(own: Path | None) -> ModelChoice:
    """The choice of a service; one that was given a model offers that one alone."""
    if own is not None:
        return ModelChoice(own)
    return ModelChoice(None, dict(list(packaged_models().items())[1:]))
