"""A fit as DICOM objects of one study: the report (PDF), fitted skin and scan (STL), and the measures (TID 1500).
Written to a folder, sent to an archive by C-STORE or STOW-RS, or both.  Sending twice does not double them."""

import argparse
from pathlib import Path

from breastrig.cli.interruption import raise_if_asked
from breastrig.cli.messages.say import say
from breastrig.cli.options.output_options import add_model, add_same_patient
from breastrig.core.errors import BadInput
from breastrig.use.archive.dicom import send_dicom, write_dicom

ARCHIVE = ("calling", "tls", "ca", "certificate", "authorization")  # options that are a node's fields
OBJECTS = ("report", "measures", "skin", "scan")


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("fit", type=Path, metavar="OUT", help="folder that `breastrig fit` wrote")
    parser.add_argument("-o", "--output", type=Path, metavar="DIR", help="folder for the files")
    parser.add_argument("--force", action="store_true", help="replace files that are no earlier result")
    parser.add_argument("--send", dest="dicom", metavar="AE@HOST:PORT", default="", help="an archive, by C-STORE")
    parser.add_argument("--stow", metavar="URL", default="", help="an archive, by STOW-RS")
    parser.add_argument("--only", dest="objects", nargs="+", choices=OBJECTS, default=OBJECTS, help="send only these")
    parser.add_argument(
        "--identities",
        type=Path,
        metavar="FILE",
        help="the hospital's own CSV or TOML: code, id, name, birth_date, sex, accession; without it the code is the "
        "PatientID, and the objects say so",
    )
    parser.add_argument("--code", default="", help="the patient's code, never a name; by default that of the fit")
    parser.add_argument("--plan", type=Path, metavar="FILE", help="plan or drawing instead of the fit's own drawing")
    parser.add_argument("--calling", metavar="AE", default="BREASTRIG", help="our own AE title (default BREASTRIG)")
    parser.add_argument("--tls", action="store_true", help="C-STORE over TLS")
    parser.add_argument("--ca", type=Path, metavar="PEM", help="who signed the archive's certificate")
    parser.add_argument("--certificate", type=Path, metavar="PEM", help="our own certificate with its key")
    parser.add_argument(
        "--authorization", type=Path, metavar="FILE", help="file with the Authorization header for STOW-RS"
    )
    add_model(parser, "the rig that the fit was made with")
    add_same_patient(parser)


def run(options: argparse.Namespace) -> int:
    """Writes, sends and says what was stored; returns 0."""
    addresses = {name: found for name in ("dicom", "stow") if (found := getattr(options, name))}
    if options.output is None and not addresses:
        raise BadInput("Say where to: a folder (-o DIR), an archive (--send AE@HOST:PORT or --stow URL), or both.")
    common = {name: getattr(options, name) for name in ("plan", "code", "identities", "same_patient", "model")}
    if options.output is not None:
        write_dicom(options.fit, options.output, force=options.force, asked_to_stop=raise_if_asked, **common)
    if addresses:
        to = addresses | {name: getattr(options, name) for name in (*ARCHIVE, "objects")}
        say(*send_dicom(options.fit, **common, **to))
        print(f"{options.dicom or options.stow} stored all of them; storage commitment was not asked for.")
    return 0
