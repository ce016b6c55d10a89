"""`breastrig evaluate COHORT -o DIR`: how good is the fit?  Tables, figures and a summary from a folder of patients.

Finished work is kept in DIR/work: an interrupted run resumes, and a changed input is measured again.
"""

import argparse
import os
import sys
from pathlib import Path

from tqdm import tqdm

from breastrig.cli.interruption import raise_if_asked
from breastrig.cli.options.output_options import add_model, add_output_options, output_folder
from breastrig.core.errors import BadInput
from breastrig.core.output_files import Output, OutputSet, all_or_nothing, check_output
from breastrig.core.private_files import private_folder
from breastrig.fitting.recipe import load_recipe
from breastrig.gltf.read_rig import default_rig_path
from breastrig_studies.cohort import GROUPS, Case, read_cohort
from breastrig_studies.evaluate import measured
from breastrig_studies.output.charts import have_plots
from breastrig_studies.output.publish import (
    NO_PLOTS,
    RECORD,
    SCHEMA,
    possible_files,
    published,
)
from breastrig_studies.output.summary import Circumstances
from breastrig_studies.studies.plan import Plan
from breastrig_studies.studies.result_cache import FILES
from breastrig_studies.studies.rotation_counts import QUICK_ROTATIONS, ROTATIONS
from breastrig_studies.tables.accuracy import console, failures_table
from breastrig_studies.tables.colour_landmarks import console as landmarks_by_colour
from breastrig_studies.tables.ink import console as colour_console
from breastrig_studies.test_set import check_unseen, commit, log_line


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "cohort", type=Path, nargs="?", metavar="COHORT", help="PATIENT/STANCE/{scan.ply, landmarks.json, ...}"
    )
    parser.add_argument("--virtual", action="store_true", help="make the virtual cohort into DIR/cohort and take it")
    parser.add_argument(
        "--warped",
        type=int,
        metavar="N",
        help="make N warped bodies into DIR/warped and take them; a COHORT's patients are warped, too",
    )
    parser.add_argument(
        "--prone",
        action="store_true",
        help="warped bodies as a breast MRI shows them, into DIR/prone; the COHORT's patients need PATIENT/prone",
    )
    parser.add_argument(
        "--hanging",
        type=float,
        metavar="SHARE",
        help="of the warped bodies, whose breasts hang (0.25); 0 for none, 1 for all",
    )
    parser.add_argument(
        "--painted",
        action="store_true",
        help="paint the virtual cohort into DIR/painted: colour is measured",
    )
    parser.add_argument(
        "--half",
        choices=(*GROUPS[:2], "both"),
        help="of the warped bodies or the painted patients; the halves share no source (both)",
    )
    parser.add_argument(
        "--test",
        type=Path,
        metavar="LOG",
        help="only the COHORT's test set, which is left out otherwise; appends what was found to a log",
    )
    parser.add_argument(
        "--preset",
        action="append",
        metavar="NAME",
        help="default, paper, or a TOML file; may be given several times, the first one is studied (default, paper)",
    )
    add_model(parser, "another rig of the same form")
    parser.add_argument("--quick", action="store_true", help="Table 1 and the study of the landmarks only")
    parser.add_argument(
        "--rotations",
        type=int,
        metavar="N",
        help=f"random orientations of each scan ({ROTATIONS}, quick {QUICK_ROTATIONS}); 0 for none",
    )
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, metavar="N", help="processes at a time")
    parser.add_argument("--again", action="store_true", help="measure finished work again")
    add_output_options(parser, "DIR", "folder for the results")


def _cohort(options: argparse.Namespace) -> Path:
    """The folder of the patients; the virtual ones are made when they are not there yet."""
    if options.painted:
        return _painted(options)
    if options.warped is not None:
        return _warped(options)
    if options.prone:
        raise BadInput("--prone is how warped bodies are scanned; give --warped N.")
    if options.hanging is not None:
        raise BadInput("--hanging is a share of the warped bodies; give --warped N.")
    if options.half is not None:
        raise BadInput("--half is a half of the warped or the painted patients; give --warped N or --painted.")
    if options.virtual and options.cohort is not None:
        raise BadInput("Give a COHORT folder or --virtual, not both.")
    if not options.virtual:
        if options.cohort is None:
            raise BadInput("Give a COHORT folder, or --virtual for the virtual patients.")
        return Path(options.cohort)
    folder = Path(options.output) / "cohort"
    if not any(folder.glob("*/*/scan.ply")):
        from breastrig_studies.virtual import make_cohort
        from breastrig_studies.virtual.bodies import read_bodies

        names = {patient.name for patient in read_bodies().patients}
        if folder.is_dir() and any(each.name not in names for each in folder.iterdir()):
            raise BadInput(f"{folder} holds other things than virtual patients; choose another folder with -o.")
        private_folder(folder)
        with tqdm(unit="scan", disable=not sys.stderr.isatty(), leave=False, desc="virtual patients") as bar:

            def progress(what: str) -> None:
                bar.set_postfix_str(what)
                bar.update()

            make_cohort(folder, progress)
    return folder


def _painted(options: argparse.Namespace) -> Path:
    """The folder of the painted patients of the half that is asked for, with those that were not there yet."""
    from breastrig_studies.virtual.painted import make_painted

    if options.virtual or options.warped is not None or options.cohort is not None:
        raise BadInput("Give --painted alone: it makes its own patients.")
    folder = Path(options.output) / "painted"
    private_folder(folder)
    with tqdm(unit="scan", disable=not sys.stderr.isatty(), leave=False, desc="painted patients") as bar:

        def progress(what: str) -> None:
            bar.set_postfix_str(what)
            bar.update()
            raise_if_asked()

        make_painted(folder, progress, sorted(_painted_names(options)))
    return folder


def _painted_names(options: argparse.Namespace) -> set[str]:
    from breastrig_studies.virtual.painted import painted_patients

    return set(painted_patients(options.half or "both"))


def _warped(options: argparse.Namespace) -> Path:
    """The folder of the warped bodies, with those that were not there yet."""
    from breastrig_studies.virtual.warped import make_warped
    from breastrig_studies.virtual.warped.numbers import HANGING
    from breastrig_studies.virtual.warped.prone import make_prone

    if options.virtual:
        raise BadInput("Give --warped or --virtual, not both.")
    if options.warped < 1:
        raise BadInput("--warped must be 1 or more.")
    share = HANGING if options.hanging is None else options.hanging
    if not 0.0 <= share <= 1.0:
        raise BadInput("--hanging is a share of the bodies; give a number from 0 to 1.")
    if options.prone and (options.cohort is None or options.hanging is not None):
        raise BadInput("--prone needs a COHORT with prone patients, and takes no --hanging.")
    kind = "prone" if options.prone else "warped"
    folder = Path(options.output) / kind
    if folder.is_dir() and any(not each.name.startswith(f"{kind}_") for each in folder.iterdir()):
        raise BadInput(f"{folder} holds other things than warped bodies; choose another folder with -o.")
    private_folder(folder)
    with tqdm(unit="scan", disable=not sys.stderr.isatty(), leave=False, desc="warped bodies") as bar:

        def progress(what: str) -> None:
            bar.set_postfix_str(what)
            bar.update()
            raise_if_asked()

        if options.prone:
            make_prone(folder, progress, options.cohort, options.warped, half=options.half or "both")
            return folder
        make_warped(folder, progress, options.cohort, options.warped, half=options.half or "both", hanging=share)
    return folder


def _cases(options: argparse.Namespace) -> tuple[Case, ...]:
    """The cases of the cohort; of the warped bodies only the requested ones, for the folder may hold more."""
    wanted = options.test is not None
    if wanted and (options.cohort is None or options.warped is not None):
        raise BadInput("--test needs a COHORT folder with a test set, and takes no synthetic ones.")
    cases = tuple(case for case in read_cohort(_cohort(options)) if case.held_out == wanted)
    if not cases:
        raise BadInput(f"{options.cohort} has {'no' if wanted else 'only'} patients of a test set.")
    if options.painted:
        names = _painted_names(options)
        return tuple(case for case in cases if case.patient in names)
    if options.warped is None:
        return cases
    from breastrig_studies.virtual.warped.make import names_of

    made = names_of(options.warped, options.half or "both", "prone" if options.prone else "warped")
    return tuple(case for case in cases if case.patient in made)


def _plan(options: argparse.Namespace) -> Plan:
    if options.jobs < 1:
        raise BadInput("--jobs must be 1 or more.")
    rotations = options.rotations
    if rotations is None:
        rotations = QUICK_ROTATIONS if options.quick else ROTATIONS
    if rotations < 0:
        raise BadInput("--rotations must be 0 or more.")
    recipes = tuple(load_recipe(name) for name in options.preset or ("default", "paper"))
    if len({recipe.name for recipe in recipes}) < len(recipes):
        raise BadInput("Two presets have the same name; give each a name of its own.")
    model = Path(options.model or default_rig_path())
    test = options.test is not None
    return Plan(_cases(options), recipes, model, rotations, options.quick or test, test)


def _output(options: argparse.Namespace, plan: Plan | None) -> Output:
    """The output folder with its possible files, and the input files known so far."""
    folder = options.output
    files = OutputSet(Path(), possible_files(folder), RECORD, SCHEMA, varying=True)
    read: list[Path] = [] if plan is None else [case.folder / name for case in plan.cases for name in FILES]
    presets = [Path(name) for name in options.preset or () if name.endswith(".toml")]
    return output_folder(options, files, also_read=[*read, *presets])


def run(options: argparse.Namespace) -> int:
    """Measures what is not yet measured, writes everything, prints the means; returns 0."""
    check_output(_output(options, None))
    plan = _plan(options)
    output = _output(options, plan)
    check_output(output)
    code = None if options.test is None else commit()
    if code is not None:
        check_unseen(options.test, code, options.again)
    private_folder(options.output)
    with tqdm(unit="fit", disable=not sys.stderr.isatty(), leave=False, smoothing=0.1) as bar:

        def progress(total: int, label: str) -> None:
            bar.total = total
            bar.set_postfix_str(label, refresh=False)
            bar.update()
            raise_if_asked()

        results = measured(plan, options.output, options.jobs, options.again, progress)
        if code is not None:
            print(log_line(options.test, code, options.cohort.name, results.records))
            return 0
        about = Circumstances(_command(options), _kind(options), options.jobs)
        with all_or_nothing(output) as out:
            published(results, about, out, lambda what: bar.set_postfix_str(what))
    if plan.plain:
        print(console(results.records, plan.recipes[0].name))
    for colour in (landmarks_by_colour(results.records), colour_console(results.records)):
        if colour:
            print(colour)
    failed = len(failures_table(results.records).rows)
    if failed:
        print(f"{failed} fits were not possible; {options.output / 'failures.csv'} says why.")
    if not have_plots():
        print(f"breastrig: {NO_PLOTS}", file=sys.stderr)
    print(f"Tables, figures and the summary: {options.output / 'evaluation.md'}")
    return 0


def _kind(options: argparse.Namespace) -> str:
    if options.warped is not None:
        return "warped bodies"
    return "virtual cohort" if options.virtual else "cohort folder"


def _command(options: argparse.Namespace) -> str:
    """The command to do it again, with the folders' own names only: a summary that is handed on tells no paths."""
    words = ["breastrig", "evaluate"]
    words += ["--virtual"] if options.virtual else []
    words += ["--warped", str(options.warped)] if options.warped is not None else []
    words += ["--prone"] if options.prone else []
    words += ["--hanging", str(options.hanging)] if options.hanging is not None else []
    words += ["--half", options.half] if options.half is not None else []
    words += [options.cohort.name] if options.cohort is not None else []
    for preset in options.preset or ():
        words += ["--preset", Path(preset).name]
    if options.model:
        words += ["--model", options.model.name]
    words += ["--quick"] if options.quick else []
    words += ["--rotations", str(options.rotations)] if options.rotations is not None else []
    return " ".join([*words, "-o", options.output.name])
