"""A patient's plan on the scan of one of the patient's fits, transferred from other scans.

Each is made in a process of its own and cached in memory only, for transferred items must not outlive the deletion of
their scan.  Which fits belong to the patient's other scans is decided here: of each the newest that is done.
"""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from breastrig.core.documents import indented
from breastrig.core.errors import Conflict, NotFound
from breastrig.drawings.plan_schema import empty_plan_on_scan
from breastrig.execution.pool import TaskQueue
from breastrig.service.failed_tasks import explained
from breastrig.service.kept_models import KeptModels
from breastrig.service.remembered import Remembered
from breastrig.storage.documents.fits import StoredFit, get_fit, newest_done
from breastrig.storage.documents.patients import (
    PatientPlan,
    get_patient,
    get_plan,
    patient_of_scan,
    said_same,
    scans_of_patient,
)
from breastrig.storage.documents.scans import get_scan
from breastrig.storage.files import fit_place
from breastrig.storage.storage import Storage
from breastrig.use.folder.one_body import BodyIssue
from breastrig.use.lines.plan_on_fit import PlanJob, PlannedFit, compared_bodies, plan_on_fit

UNFITTED = (
    "It was made on a scan that is not fitted yet, or with another version of the model; fit that one to see it here."
)
WALL_S = 180.0  # two scans take one to two seconds; a slow or busy machine with huge scans may take many
REMEMBERED = 32  # plans on scans, of some hundred kilobytes each
COMPARED = 256  # pairs of fits, a sentence each


@dataclass(frozen=True)
class PlannedFits:
    """The inputs of a plan on a scan, which identify its result."""

    patient: str
    plan: PatientPlan
    fit: StoredFit
    others: tuple[StoredFit, ...]  # of the patient's other scans
    said_same: frozenset[str] = frozenset()  # scans: a person has said that they are of one patient with the fit's
    code: str = ""  # of the patient, by which the file says whose it is
    unfitted: tuple[str, ...] = ()  # ids of items that were made on scans without a fit that is done

    @property
    def key(self) -> tuple[str, str, str, str, tuple[str, ...], frozenset[str]]:
        """A scan may become another patient's, and a plan's number may come twice."""
        others = tuple(other.id for other in self.others)
        return self.patient, self.code, self.fit.id, self.plan.etag, others, self.said_same

    @property
    def document(self) -> dict[str, Any]:
        """breastrig/plan@1"""
        return {"schema": "breastrig/plan@1", "unit": "mm", "items": list(self.plan.items)}


class Plans:
    """The plans of all patients.  May be called from any thread."""

    def __init__(self, storage: Storage, processes: TaskQueue, models: KeptModels) -> None:
        self._storage = storage
        self._processes = processes
        self._models = models
        self._remembered: Remembered[bytes] = Remembered(REMEMBERED)
        self._compared: Remembered[BodyIssue | None] = Remembered(COMPARED)

    def of_fit(self, fit_id: str) -> PlannedFits:
        """Raises NotFound, or Conflict when the fit is not done.

        Nothing is made on a predicted body: what is planned on the scan that it comes from is carried to it as well.
        """
        fit = get_fit(self._storage, fit_id)
        if fit.state != "done":
            raise Conflict(f"The fit {fit.id} is {fit.state}; a plan can be shown on fits that are done.")
        patient = patient_of_scan(self._storage, fit.scan)
        plan = get_plan(self._storage, patient)
        named = {item.get("scan") for item in plan.items}
        own = None if fit.predicted_from is None else get_fit(self._storage, fit.predicted_from)
        others = [scan for scan in scans_of_patient(self._storage, patient) if scan != fit.scan]
        found = {scan: self._beside(fit, newest_done(self._storage, scan)) for scan in others}
        found |= {} if own is None or own.scan not in named else {own.scan: own}
        unfitted = tuple(str(item["id"]) for item in plan.items if found.get(str(item.get("scan")), fit) is None)
        others_found = tuple(other for other in found.values() if other is not None)
        code = get_patient(self._storage, patient).code
        said = frozenset(said_same(self._storage, fit.scan))
        return PlannedFits(patient, plan, fit, others_found, said, code, unfitted)

    def _beside(self, fit: StoredFit, other: StoredFit | None) -> StoredFit | None:
        """The other fit, if lines can be carried between the two: they were made with one model."""
        if other is None or self._models.sha256_of(other.id) != self._models.sha256_of(fit.id):
            return None
        return other

    def on_fit(self, fit_id: str) -> bytes:
        """The plan on the fit's scan: breastrig/drawing@1 with the item of each line.

        Raises a BreastRigError with a sentence, NotFound when a fit was deleted meanwhile.
        """
        return self.laid(self.of_fit(fit_id))

    def laid(self, planned: PlannedFits) -> bytes:
        """The plan on the fit's scan as `on_fit` gives it, for a plan that has been looked up."""
        return self._remembered.result(planned.key, lambda: self._content(planned))

    def lines_on_fit(self, fit_id: str) -> tuple[dict[str, Any], bool] | None:
        """The plan on the fit's scan as a document, and whether it replaces the fit's drawing; None without a plan."""
        planned = self.of_fit(fit_id)
        if planned.plan.version == 0:
            return None
        document: dict[str, Any] = json.loads(self.on_fit(fit_id))
        return document, planned.plan.is_whole

    def doubts_of(self, fit_id: str) -> tuple[str, ...]:
        """Why the patient's other scans may be another patient's, or that they were not compared, a sentence each."""
        return tuple(json.loads(self.on_fit(fit_id)).get("doubts", ()))

    def fitted_glb(self, fit_id: str) -> bytes | None:
        """The fit's fitted.glb with the plan on it; None where the fit's own drawing is all that there is.

        Raises as `on_fit`, and NotFound when the fit has no such file.
        """
        found = self.lines_on_fit(fit_id) if self.of_fit(fit_id).plan.is_whole else None
        if found is None:
            return None
        file = self._storage.files.find(fit_place(fit_id), "fitted.glb")
        if file is None:
            raise NotFound("This fit has no fitted.glb.")
        with file.open() as opened:
            fitted = opened.read()
        from breastrig.use.lines.planned_glb import planned_glb  # as in api/served_model.py

        return planned_glb(fitted, found[0])

    def forget(self) -> None:
        """Clears the cache after a deletion."""
        self._remembered.forget()
        self._compared.forget()

    def _content(self, planned: PlannedFits) -> bytes:
        found = self._made(planned) if planned.plan.items or planned.others else self._empty(planned)
        named = {item.get("scan") for item in planned.plan.items} - {each["scan"] for each in found.get("asked", ())}
        known = {
            "version": planned.plan.version,
            "whole": planned.plan.is_whole,
            "fit": planned.fit.id,
            "patient": planned.code,
            "carried_from": [{"scan": fit.scan, "fit": fit.id} for fit in planned.others if fit.scan in named],
        }
        missing = [*found["missing"], *({"item": item, "reason": UNFITTED} for item in planned.unfitted)]
        for fit in (planned.fit, *planned.others):
            get_fit(self._storage, fit.id)  # NotFound when it was deleted meanwhile
        return indented(found | {"missing": missing} | known).encode()

    def _made(self, planned: PlannedFits) -> dict[str, Any]:
        fits = (planned.fit, *planned.others)
        ids = [fit.id for fit in fits]
        with (
            explained("Carrying this plan", WALL_S, "give smaller scans", self._storage, ids),
            self._models.of_fits(ids) as model,
        ):
            here, *others = (
                PlannedFit(
                    self._storage.files.folder(fit_place(fit.id)),
                    fit.scan if fit.predicted_from is None else fit.id,
                    self._doubt(planned, fit, model),
                )
                for fit in fits
            )
            job = PlanJob(planned.document, here, tuple(others), model)
            found: dict[str, Any] = self._processes.result(plan_on_fit, (job,), WALL_S)
        return found

    def _doubt(self, planned: PlannedFits, other: StoredFit, model: Path | None) -> BodyIssue | None:
        """Whether the other fit is of the patient's body, compared once for all versions of the plan."""
        if other is planned.fit or other.scan in planned.said_same:
            return None
        folders = [self._storage.files.folder(fit_place(fit.id)) for fit in (other, planned.fit)]
        return self._compared.result(
            (other.id, planned.fit.id),
            lambda: self._processes.result(compared_bodies, (*folders, model), WALL_S),
        )

    def _empty(self, planned: PlannedFits) -> dict[str, Any]:
        empty = empty_plan_on_scan(get_scan(self._storage, planned.fit.scan).facts["unit"])
        return empty if planned.fit.predicted_from is None else empty | {"predicted": True}
