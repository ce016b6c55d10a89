"""The models that fits were made with: the service's own, and those of earlier servers, each kept under its hash.

A fit's parameters mean nothing without its model, and a model changes with the program.  So each server keeps the one
that it fits with, some megabytes once for each version, and whatever is asked about an older fit is asked of its own.
"""

import io
import json
import logging
import zipfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import cached_property
from pathlib import Path
from typing import Any

from breastrig.core.errors import BadInput, NotFound, unknown_name
from breastrig.core.model_choice import FACT, model_choice
from breastrig.core.scratch import scratch_folder
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.model import Rig
from breastrig.storage.documents.events import event_of_kind
from breastrig.storage.documents.fits import get_fit
from breastrig.storage.documents.scans import get_scan
from breastrig.storage.files import MODELS
from breastrig.storage.storage import Storage

LONG_AGO = (1980, 1, 1, 0, 0, 0)  # of all entries, so that the same files are the same bytes
FASTEST = 1  # level of compression, for each start packs: a tenth larger than level 6, in a quarter of the time
GRAVITY = "gravity.json"  # of what is known of a rig (rig/known.py)
DIFFERENT = "These fits were made with different versions of the model; fit the older scan again."

log = logging.getLogger(__name__)


class KeptModels:
    """The kept models. May be called from any thread."""

    def __init__(self, storage: Storage, model: Path | None) -> None:
        self._storage = storage
        self._choice = self.choice = model_choice(model)

    @cached_property
    def _own(self) -> Rig:
        return read_rig(self._glb)

    @cached_property
    def names(self) -> tuple[str, ...]:
        """The names of all available models, the service's own first."""
        return (self._own.name, *self._choice.others)

    def facts_of(self, name: str | None) -> dict[str, str]:
        """The facts to store with a scan that is to be fitted with the model of that name (None: the service's own).

        Raises NotFound.
        """
        if name is not None and name not in self.names:
            raise NotFound(unknown_name("model", name, self.names))
        return {FACT: name} if name in self._choice.others else {}

    def name_of(self, facts: Mapping[str, Any]) -> str:
        """The name of the model of a stored scan."""
        found = facts.get(FACT, "")
        return found if found in self._choice.others else self._own.name

    def path_of(self, facts: Mapping[str, Any]) -> Path | None:
        """The model's .glb; None: the package's torso."""
        return self._choice.of(facts)

    @cached_property
    def _paths(self) -> dict[str, Path]:
        """The .glb of each by its hash."""
        return {read_rig(glb).sha256: glb for glb in (self._glb, *self._choice.others.values())}

    def keep(self) -> None:
        """Keeps the service's own models, unless they are kept already; a full disk is only logged."""
        try:
            for sha256, glb in self._paths.items():
                packed, name = _packed(glb), _name(sha256)
                kept = self._storage.files.find(MODELS, name)
                if kept is None or kept.size != len(packed):
                    self._storage.files.write(MODELS, name, packed)
        except OSError as error:
            log.warning("the model could not be kept beside its fits: %s", error.strerror)

    def sha256_of(self, fit_id: str) -> str:
        """The hash of the model that the fit was made with; its scan's for one that has not started."""
        started = event_of_kind(self._storage, fit_id, "started")
        if started is None:
            scan = get_scan(self._storage, get_fit(self._storage, fit_id).scan)
            return read_rig(self.path_of(scan.facts) or default_rig_path()).sha256
        return str(json.loads(started.json)["model_sha256"])

    def check_predicts(self, fit_id: str) -> None:
        """Raises BadInput when no other stance can be predicted from a fit."""
        glb = self._paths.get(self.sha256_of(fit_id))
        if glb is None:
            raise BadInput("This fit was made with another version of the model; fit the scan again, then predict.")
        if GRAVITY not in read_rig(glb).known:
            raise BadInput(f"What gravity does to {glb.stem} is not known; only the package's own model predicts.")

    @contextmanager
    def of_fits(self, fit_ids: Sequence[str]) -> Iterator[Path | None]:
        """The model that these fits were made with, as jobs take it (None: the package's), inside the block.

        Raises BadInput when they were made with different ones.  Where theirs is not kept, it is the service's own.
        """
        hashes = {self.sha256_of(fit_id) for fit_id in fit_ids}
        if len(hashes) > 1:
            raise BadInput(DIFFERENT)
        with self.at_hand(hashes.pop()) as glb:
            yield glb

    @contextmanager
    def at_hand(self, sha256: str) -> Iterator[Path | None]:
        """The model with that hash, inside the block; the service's own where it is not kept."""
        own = self._paths.get(sha256)
        kept = None if own else self._storage.files.find(MODELS, _name(sha256))
        if kept is None:
            yield self._choice.own if own in (None, self._glb) else own
            return
        with scratch_folder() as folder:
            with kept.open() as file, zipfile.ZipFile(file) as packed:
                packed.extractall(folder)
            yield next(folder.glob("*.glb"))

    @property
    def _glb(self) -> Path:
        return self._choice.own or default_rig_path()


def _name(sha256: str) -> str:
    return f"{sha256}.zip"


def _packed(glb: Path) -> bytes:
    """The rig's files as one, by their places beside the .glb."""
    files = (glb, glb.with_suffix(".json"), *glb.parent.glob("drawings/*.json"), *glb.with_suffix(".known").glob("*"))
    target = io.BytesIO()
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as packed:
        for file in sorted(files):
            name = file.relative_to(glb.parent).as_posix()
            packed.writestr(zipfile.ZipInfo(name, LONG_AGO), file.read_bytes(), zipfile.ZIP_DEFLATED, FASTEST)
    return target.getvalue()
