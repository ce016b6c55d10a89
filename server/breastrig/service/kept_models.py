"""The models that fits were made with: the service's own, and those of earlier servers, each kept under its hash.

A fit's parameters mean nothing without its model, and a model changes with the program.  So each server keeps the one
that it fits with, some megabytes once for each version, and whatever is asked about an older fit is asked of its own.
"""

import io
import json
import logging
import zipfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import cached_property
from pathlib import Path

from breastrig.core.errors import BadInput
from breastrig.core.scratch import scratch_folder
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.model import Rig
from breastrig.storage.files import MODELS
from breastrig.storage.rows.events import event_of_kind
from breastrig.storage.storage import Storage

LONG_AGO = (1980, 1, 1, 0, 0, 0)  # of all entries, so that the same files are the same bytes
GRAVITY = "gravity.json"  # of what is known of a rig (rig/known.py)
DIFFERENT = "These fits were made with different versions of the model; fit the older scan again."

log = logging.getLogger(__name__)


class KeptModels:
    """May be called from any thread."""

    def __init__(self, storage: Storage, model: Path | None) -> None:
        self._storage = storage
        self._model = model

    @cached_property
    def _own(self) -> Rig:
        return read_rig(self._glb)

    @property
    def own_sha256(self) -> str:
        """Of the model that this service fits with."""
        return self._own.sha256

    def keep(self) -> None:
        """Keeps the service's own model, unless it is kept already; a full disk is only logged."""
        try:
            packed, name = _packed(self._glb), _name(self.own_sha256)
            kept = self._storage.files.find(MODELS, name)
            if kept is None or kept.size != len(packed):
                self._storage.files.write(MODELS, name, packed)
        except OSError as error:
            log.warning("the model could not be kept beside its fits: %s", error.strerror)

    def sha256_of(self, fit_id: str) -> str:
        """Of the model that the fit was made with; the service's own for one that has not started."""
        started = event_of_kind(self._storage, fit_id, "started")
        return self.own_sha256 if started is None else str(json.loads(started.json)["model_sha256"])

    def check_predicts(self, fit_id: str) -> None:
        """Raises BadInput when no other stance can be predicted from a fit."""
        if self.sha256_of(fit_id) != self.own_sha256:
            raise BadInput("This fit was made with another version of the model; fit the scan again, then predict.")
        if GRAVITY not in self._own.known:
            raise BadInput(
                f"What gravity does to {self._own.name} is not known; only the package's own model predicts."
            )

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
        kept = None if sha256 == self.own_sha256 else self._storage.files.find(MODELS, _name(sha256))
        if kept is None:
            yield self._model
            return
        with scratch_folder() as folder:
            with kept.open() as file, zipfile.ZipFile(file) as packed:
                packed.extractall(folder)
            yield next(folder.glob("*.glb"))

    @property
    def _glb(self) -> Path:
        return self._model or default_rig_path()


def _name(sha256: str) -> str:
    return f"{sha256}.zip"


def _packed(glb: Path) -> bytes:
    """The rig's files as one, by their places beside the .glb."""
    files = (glb, glb.with_suffix(".json"), *glb.parent.glob("drawings/*.json"), *glb.with_suffix(".known").glob("*"))
    target = io.BytesIO()
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as packed:
        for file in sorted(files):
            name = file.relative_to(glb.parent).as_posix()
            packed.writestr(zipfile.ZipInfo(name, LONG_AGO), file.read_bytes(), zipfile.ZIP_DEFLATED)
    return target.getvalue()
