"""Writes the parts of the reference pages that are data of the program: python docs/reference/generate.py

They stand between `<!-- data: NAME -->` and `<!-- end -->`; everything else of a page is written by hand.
tests/contracts/test_reference_pages.py compares them, and asks for the sentences that each landmark, measure, parameter
and message needs.
"""

import ast
import re
import sys
import tomllib
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path

import numpy as np
from pydantic import BaseModel

import breastrig
from breastrig.colour.features.observation import LOOKED_FOR
from breastrig.core.assets import packaged_models
from breastrig.core.errors import unknown_name
from breastrig.core.stances import PRONE, STANDING, SUPINE, split_side
from breastrig.drawings.pattern_parameters import PatternParameter, parameters_of
from breastrig.drawings.patterns import PATTERNS
from breastrig.fitting.body.landmarks import TIPS, landmark_errors
from breastrig.fitting.uncertainty.radii import HOLDS_90
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.relief.limits import relief
from breastrig.relief.prone import ERRORS
from breastrig.rig.model import Rig
from breastrig.scan.landmarks.names import WORDS

HERE, PACKAGE = Path(__file__).parent, Path(breastrig.__file__).parent
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


PAGES: Mapping[str, Callable[[Rig], Mapping[str, str]]] = {
    "landmarks.md": landmark_blocks,
    "patterns.md": pattern_blocks,
}
MESSAGES: Mapping[str, Callable[[Rig], frozenset[str]]] = {  # the sentences that the tables of a page must explain
    "patterns.md": refusals,
}


PLACEHOLDER = re.compile(r"\{[^{}]*\}|…+")


def sentences(modules: Iterable[str], *, raised: bool) -> frozenset[str]:
    """The texts of three words and more in these modules of the package, … for what is filled in.

    `raised`: only those of errors; else all that are not of docstrings and descriptions of fields.
    """
    files = [file for pattern in modules for file in sorted(PACKAGE.glob(pattern))]
    found = frozenset[str]().union(*(texts(ast.parse(file.read_text("utf-8")), raised) for file in files))
    return frozenset(text for text in found if len(text.split()) >= 3)


def texts(module: ast.Module, raised: bool) -> frozenset[str]:
    """Texts of a module as the program says them."""
    no_text = {id(each.value) for each in ast.walk(module) if isinstance(each, ast.Expr)}  # docstrings
    for each in ast.walk(module):
        if isinstance(each, ast.JoinedStr):
            no_text |= {id(part) for part in each.values}
        elif isinstance(each, ast.keyword) and each.arg in ("description", "title"):
            no_text |= {id(part) for part in ast.walk(each)}
        elif is_unknown_name(each):
            no_text |= {id(part) for argument in each.args for part in ast.walk(argument)}
    constants = {
        target.id: each.value
        for each in module.body
        if isinstance(each, ast.Assign)
        for target in each.targets
        if isinstance(target, ast.Name)
    }
    roots = [each for each in ast.walk(module) if isinstance(each, ast.Raise)] if raised else [module]
    named = [constants[n.id] for root in roots for n in ast.walk(root) if isinstance(n, ast.Name) and n.id in constants]
    nodes = [node for root in (*roots, *named) for node in ast.walk(root) if id(node) not in no_text]
    return frozenset(PLACEHOLDER.sub("…", said).strip() for node in nodes if (said := text_of(node)) is not None)


def is_unknown_name(node: ast.AST) -> bool:
    return isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == unknown_name.__name__


def text_of(node: ast.AST) -> str | None:
    if is_unknown_name(node):
        what = text_of(node.args[0])
        return None if what is None else unknown_name(what, "…", ("…",))
    if isinstance(node, ast.JoinedStr):
        return "".join(str(part.value) if isinstance(part, ast.Constant) else "…" for part in node.values)
    return node.value if isinstance(node, ast.Constant) and isinstance(node.value, str) else None


def explained(text: str) -> list[str]:
    """The first cells of the page's tables of messages, whose head begins with `message`."""
    found = list[str]()
    for lines in re.findall(r"^\| message .*\n\|[-| ]+\|\n((?:\|.*\n)+)", text, re.MULTILINE):
        found += [line.split(" | ")[0].strip("| ") for line in lines.splitlines()]
    return found


def unexplained(text: str, said: frozenset[str]) -> list[str]:
    """Messages that the page does not have, and those of its tables that the program does not say."""
    missing = [f"{one} is missing" for one in said if one not in text]
    return sorted(missing + [f"{cell} is not said" for cell in explained(text) if not is_said(cell, said)])


def is_said(cell: str, said: frozenset[str]) -> bool:
    """Whether a message consists of what the program says."""
    rest = cell
    for one in sorted(said, key=len, reverse=True):
        rest = rest.replace(one, "")
    return not re.search(r"\w", rest)


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
