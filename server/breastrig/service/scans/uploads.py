"""Uploads and examples: a scan's bytes are read in a process of its own, and what was read of them becomes a scan.

The way of an upload: `POST /api/scans` (api/routes/scans/scans.py), `Uploads.add`, use/read_upload.py,
storage/documents/scans.py, a case.
"""

import hashlib
import json
import logging
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

from breastrig.core.assets import asset_folder
from breastrig.core.errors import BadScan, NotFound, TooLarge, unknown_name
from breastrig.core.model_choice import ModelChoice
from breastrig.core.picks import Points
from breastrig.core.stances import STANCES, Stance
from breastrig.execution.limits import UploadLimits
from breastrig.execution.pool import TaskQueue
from breastrig.fitting.prepare_scan import keeping
from breastrig.scan.images.added_lesions import LesionsRead, TakenLesions
from breastrig.scan.images.dicom_files import ZIP_START
from breastrig.scan.limits import MEBIBYTE
from breastrig.scan.stored_scan import STORED
from breastrig.scan.volumes.answers import NOTHING_SAID, VolumeAnswers
from breastrig.service.failed_tasks import FULL
from breastrig.service.kept_models import KeptModels
from breastrig.storage.documents import scans as scan_rows
from breastrig.storage.documents.patients import get_patient, put_items_of_scan
from breastrig.storage.documents.scans import StoredScan
from breastrig.storage.files import MESH, THUMBNAIL, VOLUME, scan_place, upload_name
from breastrig.storage.folders import new_id
from breastrig.storage.storage import Storage, utc_now
from breastrig.use.cases.case_work import take_lesions, volume_of
from breastrig.use.read_upload import LesionsJob, UploadJob, read_lesions, read_upload

CHUNK = 2**20
UPLOAD = "lesions"  # the file's name while it is read
EXAMPLE_LABELS = {
    "marked": "Example patient with lines of a pen",
    "standing": "Example patient, standing",
    "supine": "Example patient, supine",
    "mri": "Example patient, MRI",
}

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Example:
    name: str
    label: str
    stance: Stance
    scan: Path
    landmarks: Path


class Uploads:
    """Uploads of all clients.  May be called from any thread."""

    def __init__(
        self,
        storage: Storage,
        processes: TaskQueue,
        limits: UploadLimits,
        models: KeptModels,
        choice: ModelChoice,
        examples: Path | None,
    ) -> None:
        """`examples`: their folder, where it is not the package's."""
        self._storage, self._processes, self._limits = storage, processes, limits
        self._models, self._choice, self._examples = models, choice, examples

    def add(
        self,
        source: IO[bytes],
        file_type: str,
        units: str,
        patient: str | None = None,
        model: str | None = None,
        answers: VolumeAnswers = NOTHING_SAID,
        again: bool = False,
        group: str | None = None,
    ) -> tuple[StoredScan, list[str]]:
        """Reads an upload and keeps what was read of it, without names, comments and picture metadata.

        It is a scan of that patient, or of a new one, whom the group owns, to be fitted with the model of that name.
        With it comes what a label map's file calls its segments, which is not kept.  Raises BadScan or TooLarge with a
        sentence, of BadScan NeedsAnswer where a person has to say something, NeedsYes for a file that is a scan of that
        patient unless `again`, or NotFound for an unknown patient or model, and then keeps nothing.
        """
        chosen = self._models.facts_of(model)
        if patient is not None:
            get_patient(self._storage, patient)
        scan_id = new_id()
        place = scan_place(scan_id)
        try:
            self._storage.files.make(place)
            folder = self._storage.files.made(place)
            upload, kept = folder / upload_name(file_type), folder / upload_name(STORED)
            sha256 = _keep(source, upload, self._limits)
            model_file, triangles = self._choice.of(chosen), self._limits.triangles
            shown = folder / MESH, folder / THUMBNAIL, folder / VOLUME
            job = UploadJob(upload, units, kept, *shown, triangles, model_file, answers)
            facts = self._read(scan_id, job)
            upload.unlink()
            lesions: list[dict[str, Any]] = facts.pop("lesions", [])
            labels: list[str] = facts.pop("labels", [])
            row = StoredScan(scan_id, utc_now(), STORED, sha256, facts | chosen)
            scan_rows.add_scan(self._storage, row, patient, again, group)
            if lesions:
                items = [{"kind": "lesion", "id": new_id(), "scan": scan_id, **each} for each in lesions]
                put_items_of_scan(self._storage, scan_id, "lesion", items)
        except BaseException:
            self._processes.pool.drop(scan_id)
            self._storage.discard(place)
            raise
        return row, labels

    def add_lesions(self, scan_id: str, source: IO[bytes], answers: VolumeAnswers = NOTHING_SAID) -> TakenLesions:
        """Reads lesions of another file, which lie in the scan's image, into the plan, and its chest wall to the scan.

        Raises as `add`, Conflict where the plan has no room for them.
        """
        volume = volume_of(self._storage.case_of_scan(scan_id), scan_id)
        place = scan_place(new_id())
        try:
            self._storage.files.make(place)
            upload = self._storage.files.made(place) / UPLOAD
            _keep(source, upload, self._limits)
            task = (LesionsJob(upload, volume, answers),)
            read: LesionsRead = self._result(read_lesions, task)
        except BaseException:
            self._storage.case_of_scan(scan_id).check_scan(scan_id)  # it may have been deleted meanwhile
            raise
        finally:
            self._storage.discard(place)
        case = self._storage.case_of_scan(scan_id)  # it may have been moved
        taken = take_lesions(case, scan_id, read)
        self._storage.index.refresh(case.id)
        return taken

    def examples(self) -> tuple[Example, ...]:
        """The example patient's scans: standing, supine, prone, and of each stance by name."""
        folder = self._examples or asset_folder("example")
        found = [_example(scan) for scan in folder.glob("*/scan.*")]
        return tuple(sorted(found, key=lambda each: (STANCES.index(each.stance), each.name)))

    def add_example(self, name: str, group: str | None = None) -> tuple[StoredScan, Points]:
        """Opens an example like an upload; also its landmarks in mm.  Raises NotFound."""
        examples = {example.name: example for example in self.examples()}
        if not examples:
            raise NotFound("This copy of BreastRig holds no examples.")
        if name not in examples:
            raise NotFound(unknown_name("example", name, tuple(examples)))
        example = examples[name]
        with example.scan.open("rb") as source:
            row, _ = self.add(source, example.scan.suffix.lstrip("."), "auto", group=group)
        return row, json.loads(example.landmarks.read_text(encoding="utf-8"))["landmarks"]

    def _read(self, scan_id: str, job: UploadJob) -> dict[str, Any]:
        facts: dict[str, Any] = self._result(keeping, (read_upload, job), scan_id)
        return facts

    def _result(self, task: Callable[..., Any], given: tuple[Any, ...], key: str | None = None) -> Any:
        """What a task makes of an upload.  Raises BadScan, OSError for a full disk."""
        try:
            return self._processes.result(task, given, self._limits.wall_s, key)
        except TimeoutError as error:
            raise BadScan(
                f"Reading this scan took longer than {self._limits.wall_s:g} s; simplify it first."
            ) from error
        except (OSError, RuntimeError) as error:
            if getattr(error, "errno", None) in FULL:
                raise  # the disk's fault, not the scan's
            log.warning("the process that read an upload died: %r", error)
            raise BadScan("Reading this scan needs more memory or time than it may use; simplify it first.") from error


def _example(scan: Path) -> Example:
    about = scan.with_name("case.json")
    stance: Stance = json.loads(about.read_text("utf-8"))["stance"]
    name = scan.parent.name
    return Example(
        name, EXAMPLE_LABELS.get(name, f"Example patient, {name}"), stance, scan, scan.with_name("landmarks.json")
    )


def _keep(source: IO[bytes], path: Path, limits: UploadLimits) -> str:
    """Writes the bytes to the file, and gives up where they came from; their sha256.

    Raises BadScan when there are none, TooLarge for too many; only a zip may hold a whole examination.
    """
    digest, most = hashlib.sha256(), limits.file_bytes
    with path.open("xb") as target, source:
        while chunk := source.read(CHUNK):
            if target.tell() == 0 and chunk.startswith(ZIP_START):
                most = limits.zip_bytes
            digest.update(chunk)
            target.write(chunk)
            if target.tell() > most:
                raise TooLarge(f"This file has more than the {most // MEBIBYTE:,} MB allowed.")
        if target.tell() == 0:
            raise BadScan("This file is empty; export the scan again.")
    return digest.hexdigest()
