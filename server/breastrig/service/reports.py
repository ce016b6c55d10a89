"""The service's reports: each made in a process of its own and remembered in memory only.

Nothing of a report is kept on the disk: it may hold what was carried from another scan, and would outlive its deletion.
What is shown depends on the plan, on what is cut away by hand now and on the patient's code, so all are part of what
it is remembered by.
"""

import io
import zipfile
from collections.abc import Callable, Hashable, Sequence
from functools import partial
from pathlib import Path

from breastrig.audit.certificate import Certificate
from breastrig.core import wall_clock
from breastrig.core.errors import NotFound
from breastrig.core.identity import SAYS_NOTHING, Identity, file_name
from breastrig.execution.pool import TaskQueue
from breastrig.languages.catalogue import ENGLISH
from breastrig.service.failed_tasks import explained
from breastrig.service.kept_models import KeptModels
from breastrig.service.plans import Plans
from breastrig.service.remembered import Remembered
from breastrig.storage.documents.fits import StoredFit, get_fit, shown_cuts
from breastrig.storage.documents.patients import StoredPatient, get_patient, get_plan, patient_of_scan, said_same
from breastrig.storage.documents.scans import Cuts, cuts_digest, get_scan
from breastrig.storage.files import fit_place
from breastrig.storage.storage import Storage
from breastrig.use.archive.objects import dicom_zip_of
from breastrig.use.guides.template import guide_stl_of, template_pdf_of
from breastrig.use.reports.report import ReportJob, measures_json_of, protocol_pdf_of, report_pages_of, report_pdf_of
from breastrig.use.volume import volume_vtu_of

MAKERS: dict[str, Callable[[ReportJob], bytes]] = {
    "report.pdf": report_pdf_of,
    "pages.zip": report_pages_of,
    "measures.json": measures_json_of,
    "volume.vtu": volume_vtu_of,
    "template.pdf": template_pdf_of,
    "guide_L.stl": partial(guide_stl_of, side="L"),
    "guide_R.stl": partial(guide_stl_of, side="R"),
    "dicom.zip": dicom_zip_of,
}
PLANNED = (
    "report.pdf",
    "pages.zip",
    "template.pdf",
    "guide_L.stl",
    "guide_R.stl",
    "dicom.zip",
)  # what shows the plan; measures are those of the body
REMEMBERED = 32  # of half a megabyte, volumes of more than one
TWO_PATIENTS = f"The two scans are filed as those of two patients; {SAYS_NOTHING}"
DAY = len("2026-11-25")  # of a time as ISO 8601
WALL_S = 180.0  # two stances take about four seconds; a slow or busy machine with huge scans may take many


class Reports:
    """The reports of all fits.  May be called from any thread."""

    def __init__(self, storage: Storage, processes: TaskQueue, plans: Plans, models: KeptModels) -> None:
        self._storage = storage
        self._plans = plans
        self._processes = processes
        self._models = models
        self._remembered: Remembered[bytes] = Remembered(REMEMBERED)

    def made(self, name: str, fit_id: str, other_id: str | None = None, language: str = ENGLISH) -> bytes:
        """One of `MAKERS` of a fit that is done; report and measures also of it and another one.

        Raises a BreastRigError with a sentence, NotFound when a fit was deleted meanwhile; BadInput for a model whose
        inside is not known (volume), and for a plan whose lines cannot be laid flat (template, guides).
        """
        ids = [one for one in (fit_id, other_id) if one is not None]
        cuts = tuple(shown_cuts(self._storage, get_fit(self._storage, one)) for one in ids)
        shown = [self._key(name, one, cut) for one, cut in zip(ids, cuts, strict=True)]
        key = (name, language, *shown, self._is_said(ids))
        return self._remembered.result(key, lambda: self._made(name, ids, cuts, language))

    def page(self, number: int, fit_id: str, other_id: str | None, language: str = ENGLISH) -> tuple[bytes, int]:
        """One of the pages of report.pdf as PNG, counted from 1, and how many there are; NotFound past the last one."""
        made = self.made("pages.zip", fit_id, other_id, language)
        with zipfile.ZipFile(io.BytesIO(made)) as pages:
            count = len(pages.namelist())
            if number > count:
                raise NotFound(f"This report has {count} pages.")
            return pages.read(f"{number}.png"), count

    def dicom_for(self, fit_id: str, identities: Path) -> bytes:
        """dicom.zip with the patient of the hospital's file; it is not remembered."""
        cuts = (shown_cuts(self._storage, get_fit(self._storage, fit_id)),)
        return self._made("dicom.zip", [fit_id], cuts, ENGLISH, partial(dicom_zip_of, identities=identities))

    def protocol(self, language: str = ENGLISH) -> bytes:
        """The page for taking scans with marks."""
        return self._remembered.result(
            ("protocol", language), lambda: self._processes.result(protocol_pdf_of, (language,), WALL_S)
        )

    def certificate(self, found: Certificate, language: str = ENGLISH) -> bytes:
        """The certificate of a deletion, PDF."""
        return self._processes.result(found.pdf, (language,), WALL_S)

    def file_name(self, what: str, *fit_ids: str) -> str:
        """The name of a file of these fits: the patient's code, the stances, the day of the first scan, `what`."""
        fits = [get_fit(self._storage, one) for one in fit_ids]
        identity = self.identity(fits)
        stances = [f"{fit.stance} predicted" if fit.predicted_from else fit.stance for fit in fits]
        return file_name(identity.code, " ".join(stances), identity.day, what)

    def forget(self) -> None:
        """Clears the cache after a deletion."""
        self._remembered.forget()

    def _is_said(self, ids: list[str]) -> bool:
        """Whether a person has stated that both scans are of one patient, whatever their bodies' measures."""
        first, *others = (get_fit(self._storage, one).scan for one in ids)
        return bool(others) and set(others) <= said_same(self._storage, first)

    def _key(self, name: str, fit_id: str, cuts: Cuts) -> Hashable:
        patient = self._patient(get_fit(self._storage, fit_id))
        shown = (self._plans.of_fit(fit_id).key, patient.code) if name in PLANNED else patient.id
        return fit_id, cuts_digest(cuts), shown

    def _patient(self, fit: StoredFit) -> StoredPatient:
        return get_patient(self._storage, patient_of_scan(self._storage, fit.scan))

    def identity(self, fits: Sequence[StoredFit]) -> Identity:
        """The identity on the pages; the plan is that of the first fit's patient."""
        patient = self._patient(fits[0])
        plan = get_plan(self._storage, patient.id)
        received = tuple(get_scan(self._storage, fit.scan).created_at[:DAY] for fit in fits)
        return Identity(patient.code, wall_clock.now(), received, True, plan.written_at[:DAY], plan.version)

    def _made(
        self,
        name: str,
        ids: list[str],
        cuts: tuple[Cuts, ...],
        language: str,
        make: Callable[[ReportJob], bytes] | None = None,
    ) -> bytes:
        with (
            explained("This report", WALL_S, "fit a smaller scan", self._storage, ids),
            self._models.of_fits(ids) as model,
        ):
            folders = [self._storage.files.folder(fit_place(one)) for one in ids]
            fits = [get_fit(self._storage, one) for one in ids]
            shows_plan, is_alone = name in PLANNED, len(ids) == 1
            doubts = () if len({self._patient(fit).id for fit in fits}) == 1 else (TWO_PATIENTS,)
            job = ReportJob(
                folders[0],
                None if is_alone else folders[1],
                model,
                plans=tuple(self._plans.lines_on_fit(one) for one in ids) if shows_plan else (),
                items=self._plans.of_fit(ids[0]).plan.items if shows_plan else (),
                identity=self.identity(fits),
                doubts=self._plans.doubts_of(ids[0]) if shows_plan and is_alone else doubts,
                one_patient=self._is_said(ids),
                cuts=cuts,
                language=language,
            )
            content = self._processes.result(make or MAKERS[name], (job,), WALL_S)
        for one in ids:
            get_fit(self._storage, one)  # NotFound when it was deleted meanwhile
        return content
