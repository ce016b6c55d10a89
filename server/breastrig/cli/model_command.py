"""What `breastrig model` does; its words stand in model_options.py."""

import argparse
import subprocess
import sys

from breastrig.core.errors import BadInput
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.validation.rules import check_rig, describe_rig


def info(options: argparse.Namespace) -> int:
    """Prints a description."""
    print(describe_rig(read_rig(options.model or default_rig_path())))
    return 0


def check(options: argparse.Namespace) -> int:
    """Prints one line a rule; exit code 2 when one is broken that is more than advice."""
    findings = check_rig(read_rig(options.model or default_rig_path()))
    for finding in findings:
        mark = "ok " if finding.ok else {"error": "BAD", "advice": "tip"}[finding.severity]
        print(f"{mark} {finding.name}: {finding.detail}")
    return 0 if all(finding.ok or finding.severity == "advice" for finding in findings) else 2


def build(_options: argparse.Namespace) -> int:
    """Runs the build script beside the built model."""
    script = default_rig_path().parent.parent / "build.py"
    if not script.is_file():
        raise BadInput("The model is built in a source checkout only; clone the repository and call this there.")
    return subprocess.run([sys.executable, str(script)], check=False).returncode


def run(options: argparse.Namespace) -> int:
    """The action that was asked for."""
    return {"info": info, "check": check, "build": build}[options.action](options)
