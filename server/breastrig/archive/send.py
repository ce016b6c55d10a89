"""Sends DICOM objects to an archive: C-STORE or STOW-RS.  An object counts as stored when the archive says so of it.

No storage commitment is asked for.  Environment variables for proxies are not followed, nor are redirections: the
objects go to the address that is named, or nowhere.
"""

import io
import logging
import socket
import ssl
import zipfile
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path

from dicomweb_client import DICOMwebClient
from pydicom import dcmread
from pydicom.dataset import Dataset
from pydicom.uid import ExplicitVRLittleEndian, ImplicitVRLittleEndian
from pynetdicom import AE
from pynetdicom.association import Association
from pynetdicom.status import STORAGE_SERVICE_CLASS_STATUS, code_to_category
from requests import Response, Session
from requests import exceptions as web
from urllib3.exceptions import ConnectTimeoutError, NewConnectionError

from breastrig.archive.nodes import Node
from breastrig.core.errors import BadSettings, NotSent

CONNECT_S, GREET_S, ANSWER_S = 10.0, 30.0, 120.0
DUPLICATE = 0x0111  # the archive has the object already
AGAIN = "Send again when that is mended: what is stored is not doubled."
SHORT_OF = {  # of a rejected association: what to do
    "Called AE title not recognised": "it has another AE title than the one before the @",
    "Calling AE title not recognised": "it does not know our AE title {calling}; have it added there",
}

logging.getLogger("retrying").setLevel(logging.ERROR)  # DICOMwebClient's: a traceback of what is said in a sentence


def send_zip(content: bytes, node: Node) -> tuple[str, ...]:
    """As `send`, of a zip of `dicom_files`."""
    with zipfile.ZipFile(io.BytesIO(content)) as files:
        read = {Path(name).stem: dcmread(io.BytesIO(files.read(name))) for name in files.namelist()}
    return send(read, node)


def send(objects: Mapping[str, Dataset], node: Node) -> tuple[str, ...]:
    """Stores the objects that the node takes; returns what the archive noted, a sentence each.

    NotSent says which ones are stored and which are not, and why; BadSettings where a file of the node cannot be read.
    """
    chosen: dict[str, Dataset] = {name: each for name, each in objects.items() if name in node.objects}
    stored, failed = (_c_store if node.dicom else _stow)(chosen, node)
    if failed:
        why = "; ".join(f"{name}: {reason}" for name, reason in failed.items())
        raise NotSent(f"{node.shown} stored {' and '.join(stored) or 'nothing'}, but not {why}. {AGAIN}")
    return tuple(f"{node.shown} stored {name} with a warning: {said}." for name, said in stored.items() if said)


Outcome = tuple[dict[str, str], dict[str, str]]  # of each stored object the warning or "", of each other one the reason


def _c_store(objects: Mapping[str, Dataset], node: Node) -> Outcome:
    title, host, port = node.called
    entity = AE(node.calling)
    entity.connection_timeout = CONNECT_S
    entity.acse_timeout = GREET_S
    entity.dimse_timeout = entity.network_timeout = ANSWER_S
    for each in {each.SOPClassUID for each in objects.values()}:
        entity.add_requested_context(each, [ExplicitVRLittleEndian, ImplicitVRLittleEndian])
    secured = _context(node) if node.tls or node.ca or node.certificate else None
    tls = None if secured is None else (secured, host)
    association = entity.associate(host, port, ae_title=title, tls_args=tls)
    accepted = {str(each.abstract_syntax) for each in association.accepted_contexts}
    untaken = [name for name, each in objects.items() if each.SOPClassUID not in accepted]
    if not association.is_established and not association.rejected_contexts:
        raise NotSent(f"{node.shown} {_why_not(association, node, secured)}. Nothing was sent.")
    if untaken:
        with suppress(RuntimeError):
            association.release()
        rest = [name for name in objects if name not in untaken]
        instead = f"Send only {' and '.join(rest)}." if rest else "It may be no archive for documents."
        raise NotSent(f"{node.shown} does not take {' and '.join(untaken)}; nothing was sent. {instead}")
    stored: dict[str, str] = {}
    failed: dict[str, str] = {}
    for name, each in objects.items():
        status = association.send_c_store(each) if association.is_established else Dataset()
        code = status.get("Status")
        said = "" if code is None else f"{STORAGE_SERVICE_CLASS_STATUS.get(code, ('', ''))[1]} (status {code:04X})"
        category = "" if code is None else code_to_category(code)
        if category in ("Success", "Warning") or code == DUPLICATE:
            stored[name] = "" if category == "Success" else said
        else:
            failed[name] = said or "it did not answer"
    if association.is_established:
        association.release()
    return stored, failed


def _why_not(association: Association, node: Node, secured: ssl.SSLContext | None) -> str:
    """What is wrong; the library does not say why a connection failed, so one is made to see."""
    if association.is_rejected:
        reason = association.acceptor.primitive.reason_str  # type: ignore[union-attr]  # it is the rejection
        return f"refused: {SHORT_OF.get(reason, reason).format(calling=node.calling)}"
    _, host, port = node.called
    try:
        with socket.create_connection((host, port), CONNECT_S) as plain:
            if secured is not None:
                secured.wrap_socket(plain, server_hostname=host).close()
    except ssl.SSLError as error:
        return f"cannot be trusted or speaks no TLS ({getattr(error, 'verify_message', '') or error.reason})"
    except OSError as error:
        return f"cannot be reached ({error.strerror or 'no answer in time'})"
    return "ended the connection without an answer; it may ask for TLS, or be no DICOM node"


def _context(node: Node) -> ssl.SSLContext:
    try:
        context = ssl.create_default_context(cafile=node.ca)
        if node.certificate is not None:
            context.load_cert_chain(node.certificate)
    except OSError as error:  # ssl.SSLError too
        raise BadSettings("The certificates for the archive cannot be read; give files in PEM.") from error
    return context


def _stow(objects: Mapping[str, Dataset], node: Node) -> Outcome:
    session = Session()
    session.trust_env, session.max_redirects = False, 0
    session.headers["Accept"] = "application/dicom+json"
    session.hooks["response"].append(_plain_type)
    if node.ca or node.certificate:
        _context(node)  # BadSettings for what cannot be read
    session.verify = True if node.ca is None else str(node.ca)
    session.cert = None if node.certificate is None else str(node.certificate)
    if node.authorization is not None:
        session.headers["Authorization"] = _line_of(node.authorization)
    client = DICOMwebClient(node.stow, session=session, timeout=(CONNECT_S, ANSWER_S))
    client.set_http_retry_params(retry=False)
    answer = _answer(lambda: client.store_instances(list(objects.values())), node)
    stored = _reasons(answer, "ReferencedSOPSequence", "WarningReason")
    failed = _reasons(answer, "FailedSOPSequence", "FailureReason")
    uids = {name: str(each.SOPInstanceUID) for name, each in objects.items()}
    return (
        {name: stored[uid] for name, uid in uids.items() if uid in stored},
        {name: failed.get(uid) or "it did not say so" for name, uid in uids.items() if uid not in stored},
    )


def _reasons(answer: Dataset, sequence: str, reason: str) -> dict[str, str]:
    """By instance UID; empty where there is none."""
    return {
        str(each.get("ReferencedSOPInstanceUID")): f"reason {each[reason].value:04X}" if each.get(reason) else ""
        for each in answer.get(sequence, ())
    }


def _plain_type(response: Response, **_: object) -> None:
    """The content type without a character set, of which the client knows nothing."""
    response.headers["Content-Type"] = response.headers.get("Content-Type", "").partition(";")[0].strip()


def _answer(store: Callable[[], Dataset], node: Node) -> Dataset:
    """What the archive says of the objects, whatever its status; NotSent where it says nothing."""
    nothing = "Nothing is known to be stored."
    try:
        return store()
    except web.HTTPError as error:
        status = 0 if error.response is None else error.response.status_code
        if error.response is not None and status == 409:  # none was stored, and the body says why of each
            with suppress(ValueError, TypeError, KeyError):
                return Dataset.from_json(error.response.json())
        hint = {401: ": it asks for an authorization", 403: ": it does not let us in", 404: ": there is no STOW-RS"}
        raise NotSent(f"{node.shown} answered {status}{hint.get(status, '')}. {nothing} {AGAIN}") from error
    except web.SSLError as error:
        raise NotSent(f"{node.shown} cannot be trusted: its certificate does not verify. Nothing was sent.") from error
    except web.TooManyRedirects as error:
        raise NotSent(f"{node.shown} answered that it is elsewhere; give its own address. {nothing}") from error
    except web.ConnectionError as error:
        if not isinstance(
            getattr(error.args[0] if error.args else None, "reason", None), (NewConnectionError, ConnectTimeoutError)
        ):
            raise NotSent(f"{node.shown} ended the connection. {nothing} {AGAIN}") from error
        raise NotSent(f"{node.shown} cannot be reached. Nothing was sent.") from error
    except (web.RequestException, ValueError, KeyError) as error:  # lost on the way, or no answer that can be read
        raise NotSent(f"{node.shown} did not answer as an archive does. {nothing} {AGAIN}") from error


def _line_of(file: Path) -> str:
    try:
        line = file.read_text(encoding="ascii").strip()
    except (OSError, ValueError) as error:
        raise BadSettings(f"The authorization {file} cannot be read.") from error
    if not line.isprintable() or not line:
        raise BadSettings(f"The authorization {file} is not one line, such as: Bearer TOKEN.")
    return line
