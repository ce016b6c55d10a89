"""Objects sent to archives: what arrives, what is said of what does not, and that nothing half sent counts as sent."""

import io
import json
import ssl
import threading
from collections.abc import Callable, Iterator
from datetime import datetime
from pathlib import Path

import gdcm
import numpy as np
import pydicom
import pytest
import trustme
from dicomweb_client import DICOMwebClient
from helpers.archives import Archive, answering, tiny_archive
from helpers.written_fit import write_fit
from pydicom.dataset import Dataset
from pydicom.uid import EncapsulatedPDFStorage, EncapsulatedSTLStorage
from werkzeug.serving import make_server
from werkzeug.wrappers import Request, Response

from breastrig.archive import send as module
from breastrig.archive.identities import Patient
from breastrig.archive.nodes import node, nodes_of
from breastrig.archive.objects import CLASSES, Contents, dicom_objects
from breastrig.archive.send import send
from breastrig.cli.main import main
from breastrig.core.errors import BadSettings, NotSent
from breastrig.rig.model import Rig
from breastrig.use.archive import objects as made
from breastrig.use.archive.objects import dicom_files

pytestmark = pytest.mark.filterwarnings("ignore:Exception ignored in. <socket")  # one of pynetdicom's, not connected
TRIANGLE = (np.eye(3), np.array([[0, 1, 2]]))
ALL = set(CLASSES.values())


@pytest.fixture(scope="module")
def objects() -> dict[str, Dataset]:
    said = Contents(
        Patient("4711", "Groß^Eva"), "scan", "fit", "ab" * 32, "standing", "good", None, datetime(2026, 11, 25, 9, 30),
        b"%PDF-1.7", {"skin": TRIANGLE, "scan": TRIANGLE}, [],
    )  # fmt: skip
    return dicom_objects(said)


@pytest.fixture(scope="module")
def archive(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Archive]:
    with tiny_archive(tmp_path_factory.mktemp("archive")) as found:
        yield found


def only(objects: dict[str, Dataset], *names: str) -> dict[str, Dataset]:
    return {name: objects[name] for name in names}


def test_an_archive_of_others_stores_each_object_once_by_both_ways(
    archive: Archive, objects: dict[str, Dataset]
) -> None:
    documents = only(objects, "report", "measures")
    for _ in range(2):
        assert send(documents, node(dicom=archive.dicom)) == ()
    asked, study = DICOMwebClient(archive.stow), objects["report"].StudyInstanceUID
    assert len(asked.search_for_series(study)) == 2  # an object each
    for _ in range(2):
        assert send(objects, node(stow=archive.stow)) == ()
    assert len(asked.search_for_series(study)) == len(objects)
    sent = {each.SOPInstanceUID: each for each in map(pydicom.dcmread, map(io.BytesIO, dicom_files(objects).values()))}
    assert {each.SOPInstanceUID: each for each in asked.retrieve_study(study)} == sent
    for file in archive.files.rglob("*.dcm"):
        reader = gdcm.Reader()
        reader.SetFileName(str(file))
        assert reader.Read()


def test_what_an_archive_does_not_take_is_said_before_anything_is_sent(
    archive: Archive, objects: dict[str, Dataset]
) -> None:
    with pytest.raises(
        NotSent, match=r"does not take skin and scan; nothing was sent. Send only report and measures.$"
    ):
        send(objects, node(dicom=archive.dicom))
    with (
        answering({EncapsulatedSTLStorage}, lambda _: 0) as port,
        pytest.raises(NotSent, match=r"not take report; .* It may be no archive"),
    ):
        send(only(objects, "report"), node(dicom=f"STORE@127.0.0.1:{port}"))


def test_each_object_has_its_own_answer(objects: dict[str, Dataset]) -> None:
    statuses = {
        objects["skin"].SOPInstanceUID: 0xA700,
        objects["scan"].SOPInstanceUID: 0x0111,
        objects["measures"].SOPInstanceUID: 0xB000,
    }
    with answering(ALL, lambda each: statuses.get(each.SOPInstanceUID, 0)) as port:
        with pytest.raises(NotSent) as error:
            send(objects, node(dicom=f"STORE@127.0.0.1:{port}"))
        assert str(error.value) == (
            f"STORE@127.0.0.1:{port} stored report and measures and scan, but not skin: Refused: Out of Resources "
            "(status A700). Send again when that is mended: what is stored is not doubled."
        )
        warned = send(only(objects, "measures"), node(dicom=f"STORE@127.0.0.1:{port}"))
        assert warned == (
            f"STORE@127.0.0.1:{port} stored measures with a warning: Coercion of Data Elements (status B000).",
        )


def test_wrong_titles_are_named(objects: dict[str, Dataset]) -> None:
    with answering(ALL, lambda _: 0, calling="KNOWN") as port:
        with pytest.raises(NotSent, match=r"another AE title than the one before the @. Nothing was sent.$"):
            send(objects, node(dicom=f"WRONG@127.0.0.1:{port}", calling="KNOWN"))
        with pytest.raises(NotSent, match=r"know our AE title BREASTRIG; have it added there. Nothing was sent.$"):
            send(objects, node(dicom=f"STORE@127.0.0.1:{port}"))
        assert send(objects, node(dicom=f"STORE@127.0.0.1:{port}", calling="KNOWN")) == ()


def test_an_archive_that_does_not_answer_has_stored_nothing_for_us(
    objects: dict[str, Dataset], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "ANSWER_S", 0.2)
    done = threading.Event()
    with answering(ALL, lambda _: 0 * done.wait(5.0)) as port:
        with pytest.raises(NotSent, match=r"stored nothing, but not report: it did not answer; measures: it did not"):
            send(only(objects, "report", "measures"), node(dicom=f"STORE@127.0.0.1:{port}"))
        done.set()
    with pytest.raises(NotSent, match=r"cannot be reached \(Connection refused\). Nothing was sent.$"):
        send(objects, node(dicom=f"STORE@127.0.0.1:{port}"))
    with pytest.raises(NotSent, match=r"cannot be reached. Nothing was sent.$"):
        send(objects, node(stow=f"http://127.0.0.1:{port}/dicomweb"))


def test_c_store_over_tls_trusts_who_is_named_alone(objects: dict[str, Dataset], tmp_path: Path) -> None:
    authority, own = trustme.CA(), trustme.CA()
    secured = ssl.create_default_context(ssl.Purpose.CLIENT_AUTH)
    authority.issue_cert("127.0.0.1").configure_cert(secured)
    own.configure_trust(secured)
    secured.verify_mode = ssl.CERT_REQUIRED
    authority.cert_pem.write_to_path(str(tmp_path / "ca"))
    own.issue_cert("breastrig.hospital.example").private_key_and_cert_chain_pem.write_to_path(str(tmp_path / "own"))
    with answering(ALL, lambda _: 0, secured) as port:
        to = {"dicom": f"STORE@127.0.0.1:{port}", "certificate": tmp_path / "own"}
        assert send(objects, node(**to, ca=tmp_path / "ca")) == ()
        with pytest.raises(NotSent, match=r"cannot be trusted or speaks no TLS .*unable to get local issuer"):
            send(objects, node(**to))
    with pytest.raises(BadSettings, match="files in PEM"):
        send(objects, node(**to, ca=tmp_path / "none"))


Answer = Callable[[Request], Response]


@pytest.fixture
def web() -> Iterator[Callable[[Answer], str]]:
    """Serves one answer on loopback."""
    servers = []

    def serve(answer: Answer) -> str:
        server = make_server("127.0.0.1", 0, Request.application(answer), threaded=True)
        threading.Thread(target=server.serve_forever).start()
        servers.append(server)
        return f"http://127.0.0.1:{server.server_port}/stow"

    yield serve
    for server in servers:
        server.shutdown()
        server.server_close()


def summary(stored: list[Dataset], failed: dict[str, int], status: int) -> Response:
    found = Dataset()
    found.ReferencedSOPSequence = [Dataset() for _ in stored]
    found.FailedSOPSequence = [Dataset() for _ in failed]
    for item, each in zip(found.ReferencedSOPSequence, stored, strict=True):
        item.ReferencedSOPInstanceUID = each.SOPInstanceUID
    for item, (uid, reason) in zip(found.FailedSOPSequence, failed.items(), strict=True):
        item.ReferencedSOPInstanceUID, item.FailureReason = uid, reason
    return Response(json.dumps(found.to_json_dict()), status, content_type="application/dicom+json; charset=utf-8")


@pytest.mark.parametrize("status", [200, 202, 409])
def test_stow_counts_what_the_archive_names(
    status: int, objects: dict[str, Dataset], web: Callable[[Answer], str]
) -> None:
    stored = [] if status == 409 else [objects["report"], objects["measures"]]
    failed = {objects["skin"].SOPInstanceUID: 0x0122}
    with pytest.raises(NotSent) as error:
        send(objects, node(stow=web(lambda _: summary(stored, failed, status))))
    others = "" if stored else "report: it did not say so; measures: it did not say so; "
    assert (
        f"stored {'report and measures' if stored else 'nothing'}, but not {others}skin: reason 0122; scan: it did not"
        in str(error.value)
    )


def test_stow_goes_nowhere_else_and_carries_its_authorization_over_https_alone(
    objects: dict[str, Dataset], web: Callable[[Answer], str], tmp_path: Path
) -> None:
    asked: list[Request] = []

    def elsewhere(request: Request) -> Response:
        asked.append(request)
        return Response("", 307, {"Location": "http://127.0.0.1:9/stow"})

    with pytest.raises(NotSent, match=r"answered that it is elsewhere; give its own address. Nothing is known"):
        send(objects, node(stow=web(elsewhere)))
    assert [each.path for each in asked] == ["/stow/studies"]
    with pytest.raises(NotSent, match=r"answered 401: it asks for an authorization. Nothing is known to be stored."):
        send(objects, node(stow=web(lambda _: Response("", 401))))
    with pytest.raises(NotSent, match="but not report: it did not say so"):
        send(objects, node(stow=web(lambda _: Response("", 200))))
    with pytest.raises(NotSent, match="did not answer as an archive does"):
        send(objects, node(stow=web(lambda _: Response("no", 200, content_type="application/json"))))
    with pytest.raises(BadSettings, match="authorization is sent over https alone"):
        node(stow="http://127.0.0.1/stow", authorization=tmp_path)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('[pacs]\ndicom = "A@b"', r"\[pacs\] is no archive to send to: dicom is AE@HOST:PORT"),
        ('[pacs]\ndicom = "SEVENTEENLETTERS1@b:104"', "at most 16 characters"),
        ('[pacs]\ndicom = "A@b:104"\nstow = "https://b"', "give one address"),
        ('[pacs]\nstow = "https://user:word@b/"', "without user, password"),
        ('[pacs]\nstow = "file:///etc"', "stow is http"),
        ('[pacs]\ndicom = "A@b:104"\nobjects = ["model"]', "objects.0: Input should be 'report'"),
        ('[pacs]\ndicom = "A@b:104"\npassword = "x"', "password: Extra inputs"),
        ("[pacs", "is not TOML; write a table"),
    ],
)
def test_a_wrong_file_of_archives_is_refused(text: str, said: str, tmp_path: Path) -> None:
    (tmp_path / "archives.toml").write_text(text)
    with pytest.raises(BadSettings, match=said):
        nodes_of(tmp_path / "archives.toml")


def test_files_and_what_is_sent_are_the_same(objects: dict[str, Dataset]) -> None:
    assert set(dicom_files(objects)) == {f"{name}.dcm" for name in CLASSES}
    assert objects["report"].SOPClassUID == EncapsulatedPDFStorage


def test_the_command_sends_what_it_writes_and_says_so(
    rig: Rig, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(made, "pdf_of", lambda *_: b"%PDF")
    radii = np.full(len(rig.template), 0.002)
    fit = str(write_fit(tmp_path / "fit", rig, np.array(rig.template), radii))
    assert main(["dicom", fit, "--send", "STORE@127.0.0.1:9"]) == 2
    assert "carries no code of a patient" in capsys.readouterr().err
    assert main(["dicom", fit, "--code", "P-1"]) == 2
    assert "Say where to" in capsys.readouterr().err
    stored: list[Dataset] = []
    with answering(ALL, lambda each: stored.append(each) or 0) as port:
        to = f"STORE@127.0.0.1:{port}"
        given = ["dicom", fit, "--code", "P-1", "-o", str(tmp_path / "out"), "--send", to]
        assert main([*given, "--only", "measures"]) == 0
    assert capsys.readouterr().out == f"{to} stored all of them; storage commitment was not asked for.\n"
    assert stored == [pydicom.dcmread(tmp_path / "out" / "measures.dcm")]
    assert main(["dicom", fit, "--code", "P-1", "--send", to]) == 1
    assert "cannot be reached" in capsys.readouterr().err
