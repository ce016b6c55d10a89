"""`breastrig model info|check|bind|learn|build`: describe a rig, check it, estimate its known data."""

import argparse
import importlib
import subprocess
import sys
from pathlib import Path

from breastrig.cli.options.output_options import add_model
from breastrig.core.assets import model_path
from breastrig.core.errors import BadInput, BadModel
from breastrig.core.stances import STANCES
from breastrig.drawings.skin_maps.lying_motion import lying_motion
from breastrig.drawings.skin_maps.settings import skin_map_settings
from breastrig.fitting.body.landmarks import landmark_errors
from breastrig.fitting.body.refine import hidden_skin, trunk_depth
from breastrig.fitting.uncertainty.radii import calibration
from breastrig.fitting.verdicts.verdict import verdict_limits
from breastrig.gltf.known_files import bind_known, known_words
from breastrig.gltf.read_rig import default_rig_path, read_rig, unread_keys
from breastrig.report.calibration import measure_calibration
from breastrig.rig.body_statistics import body_statistics
from breastrig.rig.model import Rig
from breastrig.rig.validation.finding import Finding, named
from breastrig.rig.validation.rules import check_rig, describe_rig
from breastrig.volume.known_volume import FILE as VOLUME
from breastrig.volume.known_volume import known_volume


def add_options(parser: argparse.ArgumentParser) -> None:
    actions = parser.add_subparsers(dest="action", required=True, metavar="ACTION")
    for name, what in (
        ("info", "bones, shapes, landmarks and drawings of a rig"),
        ("check", "every rule that a rig must keep, one line each"),
        ("bind", "says that NAME.known beside the rig, what was estimated for it, is of the rig as it is now"),
    ):
        action = actions.add_parser(name, help=what)
        action.add_argument("given", type=model_path, nargs="?", metavar="MODEL", help="as --model")
        add_model(action, "another rig than the package's torso")
    learning = actions.add_parser("learn", help="estimates the known data of a rig, from bodies with known skin")
    learning.add_argument("model", type=model_path, metavar="MODEL", help="the rig, as for `breastrig fit --model`")
    learning.add_argument("bodies", type=Path, metavar="BODIES", help="as for `breastrig evaluate`")
    actions.add_parser("build", help="build the torso from its sources (source checkout only)")


def info(options: argparse.Namespace) -> int:
    """Prints a description."""
    glb = options.given or options.model or default_rig_path()
    rig = read_rig(glb)
    print(describe_rig(rig), known_words(glb, rig.known), sep="\n\n")
    return 0


def check(options: argparse.Namespace) -> int:
    """Prints one line a rule; exit code 2 when one is broken that is more than advice."""
    glb = options.given or options.model or default_rig_path()
    try:
        rig = read_rig(glb)
    except BadModel as error:
        print(f"BAD the rig can be read: {error}")
        return 2
    unread = unread_keys(glb)
    everything = Finding("all keys of the side file are read", not unread, named(unread) or "all of them", "advice")
    findings = [everything, *check_rig(rig)]
    read_all_known(rig)
    for finding in findings:
        mark = "ok " if finding.ok else {"error": "BAD", "advice": "tip"}[finding.severity]
        print(f"{mark} {finding.name}: {finding.detail}")
    print(f"    {known_words(glb, rig.known)}")
    return 0 if all(finding.ok or finding.severity == "advice" for finding in findings) else 2


def read_all_known(rig: Rig) -> None:
    """Reads all known data of a rig; BadModel for the first fault."""
    _ = calibration(rig), verdict_limits(rig), measure_calibration(rig), skin_map_settings(rig)
    _ = body_statistics(rig), trunk_depth(rig), lying_motion(rig)
    if VOLUME in rig.known:
        known_volume(rig)
    for stance in STANCES:
        hidden_skin(rig, stance)
        landmark_errors(rig, stance)


def bind(options: argparse.Namespace) -> int:
    """Binds NAME.known to this rig by its hash."""
    glb = options.given or options.model or default_rig_path()
    print(f"{bind_known(glb, read_rig(glb).sha256).name} names {glb.name} now.")
    return 0


def learn(options: argparse.Namespace) -> int:
    """Writes NAME.known; the studies do it, which have a package of their own."""
    try:
        studies = importlib.import_module("breastrig_studies.learn")
    except ModuleNotFoundError as error:
        raise BadInput("`breastrig model learn` needs breastrig-studies: see server/ in the repository.") from error
    print(f"{studies.learn(options.model, options.bodies)} holds what is known of {options.model.name} now.")
    return 0


def build(_options: argparse.Namespace) -> int:
    """Runs the build script beside the built model."""
    script = default_rig_path().parent.parent / "build.py"
    if not script.is_file():
        raise BadInput("The model is built in a source checkout only; clone the repository and call this there.")
    return subprocess.run([sys.executable, str(script)], check=False).returncode


def run(options: argparse.Namespace) -> int:
    """Runs the requested action."""
    return {"info": info, "check": check, "bind": bind, "learn": learn, "build": build}[options.action](options)
