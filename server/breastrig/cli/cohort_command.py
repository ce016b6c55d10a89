"""`breastrig cohort learn|merge|remove|info`: a prior from a clinic's own fits, for `breastrig fit --prior`.

    breastrig cohort learn RESULTS -o prior.json         folders that `fit` or `batch` wrote, searched whole
    breastrig cohort merge A.json B.json -o both.json
    breastrig cohort remove prior.json RESULT -o left.json

A prior holds sums over patients and hashes of their scans, no patient's own numbers.  Sums over few still tell of them.
"""

import argparse
import sys
from pathlib import Path

from breastrig.cli.messages.say import say
from breastrig.cli.options.output_options import add_model, add_output_options, writing_file
from breastrig.core.errors import BadInput
from breastrig.fitting.body.expected_body import cohort_posterior
from breastrig.fitting.recipe import load_recipe
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.cohort_posterior import FEWEST
from breastrig.rig.cohort_prior import CohortPrior, merged, read_prior, with_prior
from breastrig.rig.model import Rig
from breastrig.use.folder.cohort import cohort_of_folders


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    actions = parser.add_subparsers(dest="action", required=True, metavar="ACTION")
    learning = actions.add_parser("learn", help="the prior of the fits in folders")
    learning.add_argument("results", type=Path, nargs="+", metavar="RESULTS", help="folders of fits, searched whole")
    merging = actions.add_parser("merge", help="one prior of several of different patients")
    merging.add_argument("priors", type=Path, nargs="+", metavar="PRIOR", help="a file of `breastrig cohort`")
    removing = actions.add_parser("remove", help="the prior without the fits in folders")
    removing.add_argument("prior", type=Path, metavar="PRIOR", help="a file that this command wrote")
    removing.add_argument("results", type=Path, nargs="+", metavar="RESULT", help="folders of the patient's fits")
    info = actions.add_parser("info", help="of how many patients it is, and how much it tells")
    info.add_argument("prior", type=Path, metavar="PRIOR", help="a file that this command wrote")
    for action in (learning, removing, info):
        add_model(action, "another rig than the package's torso")
    for action in (learning, merging, removing):
        add_output_options(action, "PRIOR", "file for the prior")


def run(options: argparse.Namespace) -> int:
    """Runs the requested action."""
    if options.action == "info":
        print("\n".join(described(_rig(options), read_prior(options.prior))))
        return 0
    folders = list(getattr(options, "results", []))
    priors = list(getattr(options, "priors", [])) or ([options.prior] if "prior" in options else [])
    _not_within(options.output, folders)
    with writing_file(options) as write:
        prior = _made(options, folders, priors)
        write(prior.content())
    if sys.stdout.isatty():
        whose = ", ".join(counted(each.women, stance) for stance, each in prior.stances.items()) or "nobody"
        print(f"{options.output} is of {whose}.")
    return 0


def _made(options: argparse.Namespace, folders: list[Path], files: list[Path]) -> CohortPrior:
    priors = [read_prior(file) for file in files]
    if options.action == "merge":
        prior, sentences = merged(priors)
        say(*sentences)
        return prior
    rig = _rig(options)
    found = cohort_of_folders(folders, rig, with_example=options.action == "remove")
    say(*found.others)
    return found.prior if options.action == "learn" else priors[0].without(found.prior)


def _not_within(output: Path, folders: list[Path]) -> None:
    for folder in folders:
        if output.resolve().is_relative_to(folder.resolve()):
            raise BadInput(
                f"{output.name} would be among the results that it is made of; write it beside {folder.name}."
            )


def _rig(options: argparse.Namespace) -> Rig:
    return read_rig(options.model or default_rig_path())


def counted(women: int, stance: str) -> str:
    """The number with its noun: 1 standing patient."""
    return f"{women} {stance} patient{'' if women == 1 else 's'}"


def described(rig: Rig, prior: CohortPrior) -> list[str]:
    """A description of the prior, line by line."""
    rig, recipe = with_prior(rig, prior), load_recipe("default")
    lines = [f"for {prior.rig_name} ({prior.rig_sha256[:12]})"]
    for stance, sums in prior.stances.items():
        posterior = None if recipe.body is None else cohort_posterior(rig, recipe.shapes, recipe.body, stance)
        if posterior is not None:
            mean, spread = (sums.women / (sums.women + w) for w in (posterior.mean_strength, posterior.spread_strength))
            said = f"predicts the next such patient {posterior.closer:.0%} more closely; "
            said += f"the mean is {mean:.0%} theirs, the spread {spread:.0%}, the rest the built-in prior's"
        elif sums.women < FEWEST:
            said = f"not used, fewer than {FEWEST}"
        else:
            said = "not used, the built-in prior predicts them as well"
        lines.append(f"{counted(sums.women, stance)}: {said}")
    return lines
