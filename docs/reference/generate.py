"""Writes the parts of the reference pages that are data of the program: python docs/reference/generate.py

They stand between `<!-- data: NAME -->` and `<!-- end -->`; everything else of a page is written by hand.
tests/contracts/test_reference_pages.py compares them, and asks for the sentences that each landmark, measure, parameter
and message needs.
"""

import argparse
import ast
import csv
import inspect
import json
import re
import sys
import tomllib
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any, get_args

import numpy as np
from pydantic import BaseModel

import breastrig
from breastrig.api.errors import STATUS
from breastrig.api.settings import PREFIX, SETTINGS, SHOWN_DATA, Setting
from breastrig.cli.commands import COMMANDS, further_commands
from breastrig.cli.fit_command import SAID
from breastrig.cli.main import parser
from breastrig.colour.areolae import ObservedAreola
from breastrig.colour.features.observation import LOOKED_FOR
from breastrig.core.assets import packaged_models
from breastrig.core.errors import unknown_name
from breastrig.core.stances import PRONE, SIDES, STANDING, SUPINE, split_side
from breastrig.drawings.pattern_parameters import PatternParameter, parameters_of
from breastrig.drawings.patterns import PATTERNS
from breastrig.files.result import ResultFile
from breastrig.fitting.body.landmarks import TIPS, landmark_errors
from breastrig.fitting.uncertainty.radii import HOLDS_90
from breastrig.fitting.verdicts.verdict import Level, verdict_limits
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.relief.limits import relief
from breastrig.relief.prone import ERRORS
from breastrig.report.calibration import measure_calibration
from breastrig.report.measures import measures
from breastrig.report.pages.pdf import VERDICTS
from breastrig.report.stance import Stance
from breastrig.rig.known import NOT_CALIBRATED
from breastrig.rig.model import Rig
from breastrig.scan.landmarks.names import WORDS

HERE, PACKAGE = Path(__file__).parent, Path(breastrig.__file__).parent
PAGE_WORDS = PACKAGE.parents[1] / "web" / "src" / "languages" / "en.json"
OPENAPI, METHODS = PACKAGE / "api" / "openapi.json", ("get", "post", "put", "patch", "delete")
UNIT_WORDS = {"mm": "mm", "deg": "°", "h": "hour", "": ""}
STANCES = (STANDING, SUPINE, PRONE)
BLOCK = re.compile(r"(<!-- data: ([^>]+) -->\n)(.*?)(<!-- end -->)", re.DOTALL)
TERMS = {  # the row of the glossary that names each landmark
    "suprasternal_notch": "suprasternal notch",
    "mid_sternum": "mid-sternum",
    "xiphoid": "xiphoid process",
    "midclavicle": "midclavicular point",
    "acromion": "acromion",
    "nipple": "nipple",
    "inframammary_fold": "inframammary fold",
    "umbilicus": "umbilicus, navel",
}


def table(head: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """A Markdown table; each row has a cell for each word of the head."""
    columns = list(head)
    lines = [columns, ["---"] * len(columns), *(list(row) for row in rows)]
    if any(len(line) != len(columns) for line in lines):
        raise ValueError(f"a row of the table {columns} has another number of cells")
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def stems(rig: Rig) -> list[str]:
    """Landmarks without their sides."""
    return list(dict.fromkeys(split_side(name)[0] for name in rig.landmark_names))


def names_in_files(rig: Rig, stem: str) -> str:
    return ", ".join(f"`{name}`" for name in rig.landmark_names if split_side(name)[0] == stem)


def landmark_blocks(rig: Rig) -> Mapping[str, str]:
    """`landmarks` and one `landmark NAME` each."""
    found = {
        "landmarks": table(
            ("name in files", "term", "colour", "form", "90 % radius standing", "supine", "prone"),
            (
                (names_in_files(rig, stem), TERMS[stem], *shown_by(stem), *(radius(rig, stem, s) for s in STANCES))
                for stem in stems(rig)
            ),
        )
    }
    return found | {f"landmark {stem}": landmark_block(rig, stem) for stem in stems(rig)}


def landmark_block(rig: Rig, stem: str) -> str:
    one = next(each for each in rig.landmarks if split_side(each.name)[0] == stem)
    english, latin, german, french = glossary()[TERMS[stem]]
    colour, form = shown_by(stem)
    radii = ", ".join(f"{stance} {radius(rig, stem, stance)}" for stance in STANCES)
    rows = [
        ("English", english),
        ("Latin", latin.replace(" T", " (TA)") if latin != "–" else one.latin),
        ("Deutsch, français", f"{german}, {french}"),
        ("also read in files", ", ".join(tomllib.loads(WORDS.read_text("utf-8"))["landmarks"][stem])),
        ("definition", one.definition),
        ("shown by colour", colour),
        ("shown by the form", form),
        ("90 % radius", radii),
    ]
    return table(("name in files", names_in_files(rig, stem)), rows)


def shown_by(stem: str) -> tuple[str, str]:
    """Whether colour and form show the landmark: yes, no, or of prone patients only."""
    colour = "yes" if any(split_side(name)[0] == stem for name in LOOKED_FOR) else "no"
    if stem in relief().concavities or any(split_side(name)[0] == stem for name in TIPS):
        return colour, "yes"
    return colour, "prone" if stem in ERRORS else "no"


def radius(rig: Rig, stem: str, stance: str) -> str:
    """The 90 % radius around the place where a fit expects a landmark without a pick, beyond the fit's own error."""
    known = landmark_errors(rig, stance).get(stem)
    return "not known" if known is None else f"{HOLDS_90 * np.linalg.norm(known.deviation_mm):.0f} mm"


def glossary() -> Mapping[str, tuple[str, ...]]:
    """The rows of surgical terms, by their English cell."""
    text = (HERE / "glossary.md").read_text("utf-8").partition("## Surgical terms")[2]
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in text.splitlines() if line[:1] == "|"]
    return {row[0]: tuple(row) for row in rows[2:]}


def pattern_blocks(_rig: Rig) -> Mapping[str, str]:
    """`drawings` of all models, one `pattern NAME` each."""
    rows = [
        (f"`{drawing.name}`", drawing.label, model, ", ".join(f"`{shape.name}`" for shape in drawing.shapes))
        for model, path in packaged_models().items()
        for drawing in read_rig(path).drawings
    ]
    found = {"drawings": table(("name", "for people", "model", "lines"), rows)}
    return found | {f"pattern {name}": parameter_table(kind) for name, kind in PATTERNS.items()}


def parameter_table(kind: type[BaseModel]) -> str:
    head = ("parameter", "name on the page", "unit", "default", "limits", "meaning")
    return table(head, (parameter_row(each) for each in parameters_of(kind).values()))


def parameter_row(each: PatternParameter) -> tuple[str, ...]:
    default = "must be given" if each.needed else "–" if each.default is None else written(each.default)
    limits = "–" if each.min is None else f"{each.min:g} to {each.max:g}"
    if each.choices:
        limits = ", ".join(f"`{choice}`" for choice in each.choices)
    return f"`{each.name}`", each.label, UNIT_WORDS[each.unit], default, limits, each.about


def written(value: float | str) -> str:
    return f"`{value}`" if isinstance(value, str) else f"{value:g}"


PATTERN_MODULES = ("drawings/constructions/*.py", "drawings/clock.py", "drawings/patterns.py", "geometry/geodesic.py")


def refusals(_rig: Rig) -> frozenset[str]:
    """The sentences with which a pattern is refused."""
    return sentences(PATTERN_MODULES, raised=True)


def measure_blocks(rig: Rig) -> Mapping[str, str]:
    """`measures`, `errors` of the model's data file, and `differences` that were measured (decision 0029)."""
    return {
        "measures": table(("name in files", "label and unit", "taken", "of", "from", "positions"), measure_rows(rig)),
        "errors": table(("entry of `measures.toml`", "value", "meaning"), calibration_rows(rig)),
        "differences": table(("number", "half of the 90 % band", "true values held"), difference_rows()),
    }


def measure_rows(rig: Rig) -> Iterable[tuple[str, ...]]:
    """Every measure of the model at rest, with all landmarks picked and both areolae seen."""
    skin = rig.template
    picked = dict(zip(rig.landmark_names, rig.landmark_points().positions(skin, rig.faces), strict=True))
    areola = ObservedAreola(0.04, 0.001, skin[rig.regions["areola_L"]])
    found = {
        position: measures(
            Stance(rig, skin, skin, rig.faces, position, picked=picked, areolae=dict.fromkeys(SIDES, areola))
        )
        for position in STANCES
    }
    for name in dict.fromkeys(row.measure for row in found[STANDING]):
        rows = [row for row in found[STANDING] if row.measure == name]
        positions = [position for position in STANCES if any(row.measure == name for row in found[position])]
        sources = dict.fromkeys(spoken_source(each) for row in rows for each in row.landmarks)
        label = " ".join(rows[0].label.removeprefix(name).split())
        yield (
            f"`{name}`",
            f"{label}, {'ratio' if rows[0].unit == '1' else rows[0].unit}",
            ", ".join(row.kind for row in rows if row.unit == "mm") or "–",
            "each side" if rows[0].value is None else "both",
            ", ".join(sources),
            "all" if len(positions) == len(STANCES) else ", ".join(positions),
        )


def spoken_source(named: str) -> str:
    """A landmark or line of a row as its term, without its side and its source."""
    stem = split_side(named.partition(" (")[0])[0]
    return TERMS.get(stem, "breast outline" if "outline" in stem else stem)


CALIBRATED = {  # what each entry of measures.toml is, and whether it is in m
    "outwards": ("a fit's outline lies so much too far in; it is moved out by this", True),
    "least": ("error (90 %), whatever the fit says", True),
    "share": ("of the fit's 90 % radius there, added to it as squares", False),
    "picked": ("error (90 %) of the height of a placed nipple or fold", True),
    "lowest": ("error (90 %) of the height of the lowest skin", True),
    "covered_below": ("a nipple less than this above the xiphoid's level hides its fold", True),
    "fold_over_xiphoid": ("a hidden fold is taken so much above the xiphoid's level", True),
    "hidden_fold": ("error (90 %) of that", True),
    "volume": ("correlation of the errors of left and right", False),
    "lateral": ("correlation of the errors of left and right, of the most lateral point", False),
    "sides.lowest": ("correlation of the errors of left and right, of the lowest point", False),
    "base_width": ("correlation of the errors of left and right", False),
    "standing": ("share of the landmarks' opposite errors of left and right that counts, standing", False),
    "supine": ("share of the landmarks' opposite errors of left and right that counts, supine", False),
    "lengths": ("correlation of the errors of a patient's standing and supine fit, without placed landmarks", False),
}


def calibration_rows(rig: Rig) -> Iterable[tuple[str, ...]]:
    """Each number of the model's measures.toml."""
    known = measure_calibration(rig)
    if known is None:
        raise ValueError(f"{rig.name} has no measures.toml")
    for place, value in leaves(known.model_dump()):
        words, metres = CALIBRATED.get(".".join(place)) or CALIBRATED[place[-1]]
        yield f"`{'.'.join(place)}`", f"{1e3 * value:g} mm" if metres else f"{value:g}", words


def leaves(part: Mapping[str, Any], above: tuple[str, ...] = ()) -> Iterable[tuple[tuple[str, ...], float]]:
    """The numbers of nested tables, with the names that lead to each."""
    for name, value in part.items():
        if isinstance(value, Mapping):
            yield from leaves(value, (*above, name))
        else:
            yield (*above, name), value


def difference_rows() -> Iterable[tuple[str, ...]]:
    with (HERE.parent / "decisions" / "0029-differences.csv").open(encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file):
            if (row["bands"], row["half"]) == ("now", "validation"):
                unit = " mm" if row["unit"] == "mm" else ""
                yield row["measure"], f"{row['half_band']}{unit}", f"{row['held_percent']} %"


ANSWERS = {  # of the page's words (fit.verdict.…): when each is said
    "check": "(also two and three) landmarks are there whose check narrows the lines, or a question is open",
    "ready": "good or uncalibrated, and nothing is asked",
    "draw": "check, nothing is asked, and no reason speaks against drawing: the width of the lines follows",
    "look": "check, nothing is asked, and the reasons below it are to be looked at",
    "cannot": "unusable, or the fit has failed; the reason is below it",
}


def quality_blocks(rig: Rig) -> Mapping[str, str]:
    """`levels`: the words for each, `answers`: what the page says first, and `limits`: of the line error."""
    words = json.loads(PAGE_WORDS.read_text("utf-8"))
    said = {name: words[f"fit.verdict.{name}"] for name in ANSWERS}
    one = {name: text if isinstance(text, str) else text["one"] for name, text in said.items()}
    answers = ((re.sub(r" *\{\w+\}", "", one[name]), when) for name, when in ANSWERS.items())
    page = {level: words[f"fit.numbers.verdicts.{level}"] for level in get_args(Level)}
    rows = ((f"`{level}`", page[level], SAID[level], VERDICTS[level]) for level in get_args(Level))
    limits = verdict_limits(rig).lines
    named = (
        ("good at most, without placed landmarks", limits.check),
        ("good at most, with three placed landmarks or more", limits.placed),
        ("unusable beyond", limits.unknown),
    )
    return {
        "answers": table(("on the page", "when"), answers),
        "levels": table(("level", "on the page", "on the command line", "in the report"), rows),
        "limits": table(("line error (90 %)", "mm"), ((words, f"{1e3 * limit:g}") for words, limit in named)),
    }


QUALITY_MODULES = (
    "fitting/verdicts/*.py",
    "fitting/picks/issues.py",
    "fitting/hypotheses.py",
    "fitting/prepare_scan.py",
    "use/steps/events.py",
    "use/steps/outcome.py",
    "use/steps/prepare.py",
    "use/folder/one_body.py",
    "service/fits/*.py",
    "cases/fits.py",
    "cli/fit_command.py::_worth_a_check",
    "cli/fit_command.py::_to_check",
)


def fit_messages(rig: Rig) -> frozenset[str]:
    """What a fit says of itself, why it failed, and what is said of two fits."""
    limits = verdict_limits(rig)
    signals = () if limits is None else limits.signals.values()
    return sentences(QUALITY_MODULES) | {NOT_CALIBRATED} | {PLACEHOLDER.sub("…", signal.fact) for signal in signals}


STEPS: Mapping[str, tuple[str, str]] = {  # of a case: its routes (the first step that has one counts), and its names
    "share": ("/api/shared/|/shares", ""),
    "service": (
        "/api/meta|/api/session|/api/models|/api/examples|/api/audit|/healthz|/readyz|/metrics",
        "example Example load_model Rig __version__",
    ),
    "landmarks": (
        "/landmarks|/length$|/scan_protocol|/transfers/marks",
        "propose_landmarks Proposal Proposals propose_marks ProposedMark ProposedMarks",
    ),
    "checks": ("/checks", "LineChecks LandmarkCheck"),
    "draw": ("/plan|/pattern|/lengths|/scans/{scan_id}/drawing", "draw project Drawing Line Lesion"),
    "transfer": ("/api/transfers", "transfer"),
    "predict": ("/predictions", "predict"),
    "report": (
        "/measures.json|/report|/template|/guide",
        "measure Measure Number write_report write_template write_dicom send_dicom",
    ),
    "result": (
        "/result|/fitted|/distances|/uncertainty|/volume|/fits/{fit_id}/drawing.json",
        "Fit Frame Posterior Parameters BonePose Volume volume_mesh",
    ),
    "fit": ("/fits", "fit iterates Iterate FitRun"),
    "patients": ("/api/patients|/scans/{scan_id}/patient|DELETE /api/scans", "Case CaseScan CaseFit"),
    "upload": ("/api/scans", "read_scan Scan find_ink Ink InkLine"),
}


def api_blocks(_rig: Rig) -> Mapping[str, str]:
    """Of each step the names of Python and the routes of HTTP; `errors` with the statuses they have."""
    routes: dict[str, list[tuple[str, str, str]]] = {step: [] for step in STEPS}
    for path, operations in json.loads(OPENAPI.read_text("utf-8"))["paths"].items():
        for method, operation in operations.items():
            if method in METHODS:
                route = f"{method.upper()} {path}"
                step = next(step for step, (pattern, _) in STEPS.items() if re.search(pattern, route))
                routes[step].append(("HTTP", f"`{route}`", operation["summary"]))
    names = [name for _, listed in STEPS.values() for name in listed.split()]
    raised = [name for name in breastrig.__all__ if is_error(name)]
    if {*names, *raised} != {*breastrig.__all__}:
        raise ValueError(f"say in STEPS where these belong: {sorted({*names, *raised} ^ {*breastrig.__all__})}")
    found = {
        step: table(("", "name", ""), [*(python_row(name) for name in listed.split()), *routes[step]])
        for step, (_, listed) in STEPS.items()
    }
    return found | {"errors": table(("Python", "HTTP", "meaning"), (error_row(name) for name in raised))}


def python_row(name: str) -> tuple[str, str, str]:
    if name == "__version__":
        return "Python", "`breastrig.__version__`", "The version"
    about = inspect.getdoc(getattr(breastrig, name)) or ""
    return "Python", f"`breastrig.{name}`", " ".join(about.partition("\n\n")[0].split()).rstrip(".:")


def is_error(name: str) -> bool:
    found = getattr(breastrig, name)
    return isinstance(found, type) and issubclass(found, breastrig.BreastRigError)


def error_row(name: str) -> tuple[str, str, str]:
    kind = getattr(breastrig, name)
    status = next(status for base, status in STATUS if issubclass(kind, base))
    about = " ".join((inspect.getdoc(kind) or "").partition("\n\n")[0].split())
    return f"`breastrig.{name}`", str(status), about


def command_blocks(_rig: Rig) -> Mapping[str, str]:
    """One `command NAME` each: its purpose, and what it takes, from its own parser."""
    studies = "tables and figures of how accurate fits are, of the package `breastrig_studies`"
    purposes = COMMANDS | dict.fromkeys(further_commands(), studies)
    found = {}
    for name, purpose in purposes.items():
        [commands] = [each for each in parser(name)._actions if isinstance(each, argparse._SubParsersAction)]
        found[f"command {name}"] = f"{purpose.capitalize()}.\n\n{options_table(name, commands.choices[name])}"
    return found


def options_table(name: str, of: argparse.ArgumentParser) -> str:
    """What a command takes, then each of its own commands."""
    within = [each for each in of._actions if isinstance(each, argparse._SubParsersAction)]
    taken = [each for each in of._actions if each not in within and "--help" not in each.option_strings]
    rows = [(usage_of(each), help_of(of, each)) for each in taken]
    parts = [table((f"`{name}`", ""), rows)] if rows else []
    for each in within:
        parts += [options_table(f"{name} {word}", one) for word, one in each.choices.items()]
    return "\n".join(parts)


def usage_of(action: argparse.Action) -> str:
    """`-o OUT`, `--output OUT`, or the name of what is given without an option."""
    choices = "{" + ",".join(map(str, action.choices)) + "}" if action.choices else action.dest.upper()
    value = action.metavar or choices
    value = " ".join(value) if isinstance(value, tuple) else value
    words = [word if action.nargs == 0 else f"{word} {value}" for word in action.option_strings] or [value]
    return ", ".join(f"`{word}`" for word in words).replace("|", "\\|")


def help_of(of: argparse.ArgumentParser, action: argparse.Action) -> str:
    """The help of an option, with its default where the sentence has its place; for any user of any machine."""
    said = of._get_formatter()._expand_help(action) if action.help else ""
    return said.replace(SHOWN_DATA, "the user's data folder").replace("`", "").replace("|", "\\|")


def setting_blocks(_rig: Rig) -> Mapping[str, str]:
    """`settings`: the name of each in the settings file, as option and in the environment."""
    head = ("settings file", "option", "environment", "default", "meaning")
    return {"settings": table(head, (setting_row(name, each) for name, each in SETTINGS.items()))}


def setting_row(name: str, setting: Setting) -> tuple[str, ...]:
    option, variable = f"`--{name.replace('_', '-')}`", f"`{PREFIX}{name.upper()}`"
    default = {"data": "the user's data folder", "workers": "one a core, at most 8"}.get(name)
    meaning = setting.help.replace(SHOWN_DATA, "the user's data folder")
    return f"`{name}`", option, variable, default or setting.shown(setting.default()), meaning


FILE_MODULES: Mapping[str, tuple[str, ...]] = {  # the rooms of scan/ by what their sentences are about
    "unit and size": tuple(
        f"scan/{name}.py" for name in ("units", "unscaled", "true_size", "limits", "read", "untrusted", "winding")
    ),
    "formats": ("scan/file_type.py", "scan/formats/**/*.py", "scan/point_clouds/*.py"),
    "colours": ("scan/pictures/*.py", "scan/piece.py"),
    "label maps": ("scan/volumes/**/*.py",),
    "images": ("scan/images/**/*.py", "scan/kept_image.py"),
    "landmark files": ("scan/landmarks/*.py",),
    "cuts and orientation": (
        *(f"scan/{name}.py" for name in ("clean", "hand_cuts", "caps", "around/*", "orient", "scan", "stored_scan")),
    ),
}


def file_message_blocks(_rig: Rig) -> Mapping[str, str]:
    """The sentences of each group; ValueError for a module that is in none."""
    grouped = {file for modules in FILE_MODULES.values() for one in modules for file in PACKAGE.glob(one)}
    left = {file.name for file in PACKAGE.glob("scan/**/*.py")} - {file.name for file in grouped} - {"__init__.py"}
    if left:
        raise ValueError(f"say in FILE_MODULES what the sentences of {sorted(left)} are about")
    found = {}
    for group, modules in FILE_MODULES.items():
        whole = sorted(text for text in sentences(modules) if text.endswith(".") and re.match(r'[A-Z"]|… \w', text))
        found[group] = "".join(f"- {text}\n" for text in whole)
    return found


RESULT_WORDS = {  # of fields whose names say it all to programmers
    "schema": "`breastrig/result@1`",
    "notice": "limits of use",
    "scan": "what was read: counts, unit and why, sha256, what was cut away",
    "model": "name and sha256 of the rig",
    "stance": "standing, supine or prone",
    "stance_reason": "why, [a sentence](quality.md#position)",
    "preset": "name of the preset",
    "converged": "whether the fit stopped by itself",
    "stop_reason": "why it stopped",
    "iterations": "number of iterations",
    "timing_s": "seconds of each part",
    "surface_distance_mm": "from model vertices to the scan: mean, std, max, p95, coverage",
    "scan_to_model_mm": "from scan points within reach to the model: mean, std, max, p95",
    "landmark_distance_mm": "from placed to fitted landmarks: mean, std, max, min, each",
    "parameters": "bones and weights of shapes, by name",
    "notes": "what reading, cleaning and colours found, a sentence each",
    "versions": "of BreastRig, Python and libraries",
}


def file_blocks(_rig: Rig) -> Mapping[str, str]:
    """`result`: the fields of result.json."""
    rows = (
        (
            f"`{field.alias or name}`",
            "yes" if field.exclude_if is None else "not always",
            field.description or RESULT_WORDS[field.alias or name],
        )
        for name, field in ResultFile.model_fields.items()
    )
    return {"result": table(("field", "always there", "meaning"), rows)}


def keys_of(part: type[BaseModel], above: str = "") -> dict[str, bool]:
    """The keys of a JSON document, `bones[].name`, and whether each has to be there."""
    found = {}
    for name, field in part.model_fields.items():
        key = above + (field.alias or name)
        inner = next((each for each in get_args(field.annotation) if is_part(each)), None)
        if inner is not None:
            found |= keys_of(inner, f"{key}[].")
        elif is_part(field.annotation):
            found |= keys_of(field.annotation, f"{key}.")
        else:
            found[key] = field.is_required()
    return found


def is_part(kind: Any) -> bool:
    return isinstance(kind, type) and issubclass(kind, BaseModel)


PAGES: Mapping[str, Callable[[Rig], Mapping[str, str]]] = {
    "api.md": api_blocks,
    "commands.md": command_blocks,
    "settings.md": setting_blocks,
    "file_formats.md": file_blocks,
    "file_messages.md": file_message_blocks,
    "landmarks.md": landmark_blocks,
    "measures.md": measure_blocks,
    "patterns.md": pattern_blocks,
    "quality.md": quality_blocks,
}
MESSAGES: Mapping[str, Callable[[Rig], frozenset[str]]] = {  # the sentences that the tables of a page must explain
    "patterns.md": refusals,
    "quality.md": fit_messages,
}


PLACEHOLDER = re.compile(r"\{[^{}]*\}|…+")
NO_SENTENCES = ("description", "title", "help", "epilog", "metavar")  # keywords whose texts are of forms and commands
JOINING = {"and", "it", "or", "them"}  # what the program joins them with
LEAST_WORDS = 3  # of a text that has to be explained


def sentences(sources: Iterable[str], *, raised: bool = False) -> frozenset[str]:
    """The texts of three words and more in these modules of the package, … for what is filled in.

    A source is a module, several (`*`), or a function of one (`room/file.py::name`). `raised`: only texts of errors.
    """
    found = frozenset[str]()
    for source in sources:
        pattern, _, function = source.partition("::")
        files = sorted(PACKAGE.glob(pattern))
        if not files:
            raise ValueError(f"{source} is not there; say in generate.py where its sentences are now")
        for file in files:
            found |= texts(ast.parse(file.read_text("utf-8")), function, raised)
    return frozenset(text for text in found if pieces(text) and len(text.split()) >= LEAST_WORDS)


def texts(module: ast.Module, function: str, raised: bool) -> frozenset[str]:
    """Texts of a module as the program says them: without docstrings, log lines and forms."""
    constants = {
        target.id: each.value
        for each in module.body
        if isinstance(each, ast.Assign)
        for target in each.targets
        if isinstance(target, ast.Name)
    }
    roots: list[ast.AST] = [module]
    if function:
        roots = [each for each in module.body if isinstance(each, ast.FunctionDef) and each.name == function]
    if raised:
        roots = [each for root in roots for each in ast.walk(root) if isinstance(each, ast.Raise)]
    roots += [
        constants[n.id] for root in roots for n in ast.walk(root) if isinstance(n, ast.Name) and n.id in constants
    ]
    no_text = {id(part) for root in roots for each in ast.walk(root) for part in without_text(each)}
    nodes = [node for root in roots for node in ast.walk(root) if id(node) not in no_text]
    said = [text_of(node, constants) for node in nodes]
    return frozenset(PLACEHOLDER.sub("…", each).strip() for each in said if each is not None)


def without_text(node: ast.AST) -> list[ast.AST]:
    """The parts of a node that are no texts by themselves."""
    match node:
        case ast.Expr(value=ast.Constant()):
            return [node.value]
        case ast.JoinedStr():
            return list(node.values)
        case ast.keyword() if node.arg in NO_SENTENCES:
            return list(ast.walk(node))
        case ast.Call(func=ast.Attribute(value=ast.Name(id="log"))):
            return list(ast.walk(node))
        case ast.Call(func=ast.Name(id="unknown_name" | "unknown_names")):
            return [part for argument in node.args for part in ast.walk(argument)]
    return []


def text_of(node: ast.AST | None, constants: Mapping[str, ast.expr]) -> str | None:
    """The text of a string, … for what is filled in; None for all else."""
    match node:
        case ast.Constant(value=str()):
            return str(node.value)
        case ast.JoinedStr():
            return "".join(text_of(part, constants) or "…" for part in node.values)
        case ast.FormattedValue(value=ast.Name(id=name)):
            return text_of(constants.get(name), {})
        case ast.Call(func=ast.Name(id="unknown_name" | "unknown_names")):
            what = text_of(node.args[0], constants)
            return None if what is None else unknown_name(what, "…", ("…",))
    return None


def pieces(message: str) -> list[str]:
    """The words of a message between what is filled in."""
    return [piece for piece in message.split("…") if re.search(r"\w", piece)]


def as_pattern(message: str) -> re.Pattern[str]:
    """Finds a message in one cell of a page, whatever is filled in there."""
    return re.compile(r"[^|\n]*".join(re.escape(piece) for piece in pieces(message)), re.IGNORECASE)


def explained(text: str) -> list[str]:
    """The first cells of the page's tables of messages, whose head begins with `message`."""
    found = list[str]()
    for lines in re.findall(r"^\| message .*\n\|[-| ]+\|\n((?:\|.*\n)+)", text, re.MULTILINE):
        found += [line.split(" | ")[0].strip("| ") for line in lines.splitlines()]
    return found


def missing(text: str, said: Iterable[str]) -> list[str]:
    """Messages that the page does not have."""
    return sorted(one for one in said if not as_pattern(one).search(text))


def unsaid(text: str, said: Iterable[str]) -> list[str]:
    """Messages of the page's tables that the program does not say."""
    words = sorted({piece.strip() for one in said for piece in pieces(one)}, key=len, reverse=True)
    return [cell for cell in explained(text) if not is_said(cell, words)]


def is_said(cell: str, words: Iterable[str]) -> bool:
    """Whether a message consists of these words of the program, the longest first."""
    rest = cell
    for piece in words:
        rest = re.sub(re.escape(piece), "", rest, flags=re.IGNORECASE)
    return not {*re.findall(r"\w+", rest)} - JOINING


def rewritten(text: str, blocks: Mapping[str, str]) -> str:
    """The page with its blocks as they are now; KeyError for a block that there is no data for."""
    return BLOCK.sub(lambda found: found[1] + blocks[found[2]] + found[4], text)


def faults(text: str, blocks: Mapping[str, str]) -> list[str]:
    """Blocks that the page lacks, and those that are not as they are now."""
    on_page = {found[2]: found[3] for found in BLOCK.finditer(text)}
    missing = [f"{name} is missing" for name in blocks.keys() - on_page.keys()]
    return sorted(missing + [f"{name} is stale" for name, now in on_page.items() if blocks.get(name) != now])


def main() -> None:
    rig = read_rig(default_rig_path())
    for name, blocks_of in PAGES.items():
        page = HERE / name
        text = page.read_text("utf-8")
        page.write_text(rewritten(text, blocks_of(rig)), "utf-8")


if __name__ == "__main__":
    sys.exit(main())
