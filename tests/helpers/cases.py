"""Cases without meshes, for tests of their documents."""

import secrets
from pathlib import Path

from breastrig.cases import layout
from breastrig.cases.case_folder import CaseFolder
from breastrig.cases.documents import FitDocument, LinkDocument, ScanDocument, content_of
from breastrig.cases.fits import end_abandoned, fits_of_scan
from breastrig.cases.layout import new_id
from breastrig.cases.links import add_link
from breastrig.cases.of_scans import get_answers
from breastrig.cases.writing import put
from breastrig.drawings.plan_schema import PlanNote

FACTS = {"unit": "mm", "stance": {"proposed": "standing"}}


def data_folder(root: Path) -> Path:
    """An empty one; where its cases are."""
    (root / layout.CASES).mkdir(parents=True)
    (root / layout.MARK).write_text(new_id())
    return root / layout.CASES


def new_case(cases: Path, code: str = "") -> CaseFolder:
    return CaseFolder.create(cases / new_id(), code)


def new_scan(case: CaseFolder, skin: bytes = b"skin") -> str:
    """A scan of a file of its own."""
    with case.incoming() as made:
        (made / layout.STORED).write_bytes(skin)
        (made / layout.MESH).write_bytes(skin)
        (made / layout.VOLUME).write_bytes(skin)
        document = ScanDocument(created_at="2026-01-01T00:00:00.000Z", sha256=secrets.token_hex(32), facts=FACTS)
        return case.add_scan(made, document)


def new_fit(case: CaseFolder, scan: str) -> str:
    """A fit that waits."""
    fit = new_id()
    with case.incoming() as made:
        put(made, layout.FIT, content_of(FitDocument(asked_at="2026-01-02T00:00:00.000Z")))
        with case.writing():
            case.check_scan(scan)  # else this would make the folder of one that another writer has deleted
            case.put_folder(made, layout.fit_part(scan, fit))
    return fit


def new_link(case: CaseFolder) -> str:
    """A link to a fit of the case's first scan, which is done by then."""
    scan = case.scans()[0].id
    [fit] = [one for one in fits_of_scan(case, scan) if one.state in ("queued", "done")][:1]
    end_abandoned(case, scan, fit.id, {"kind": "done", "result": {}})
    document = LinkDocument(created_at="2026-01-03T00:00:00.000Z", expires_at="2999-01-01T00:00:00.000Z", scan="none")
    with case.incoming() as made:
        (made / "plan.json").write_text("seen through a link")
        return add_link(case, scan, fit.id, document, made)


def say(case: CaseFolder, scan: str, **answers: object) -> None:
    """Writes into answers.json what a person has said, beside what is there."""
    said = get_answers(case, scan).model_copy(update=answers)
    put(case.path, f"{layout.scan_part(scan)}/{layout.ANSWERS}", content_of(said))


def note(scan: str, text: str = "a note", item: str = "") -> PlanNote:
    return PlanNote(id=item or new_id(), scan=scan, text=text)
