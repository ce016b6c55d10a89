"""Mutation testing of the numeric rooms: wrong changes, made one at a time in a copy; those that no test sees survive.

    python tests/mutants.py fitting drawings --count 40 --seed 1

Signs and comparisons are turned, numbers doubled, sides exchanged, inverses (.T) dropped, smallest and largest
exchanged.  Of a room first those tests run that name the module, then the room's others.
"""

import argparse
import ast
import os
import random
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOMS = (
    "geometry",
    "scan",
    "colour",
    "relief",
    "drawings",
    "validation",
    "fitting",
    "rig",
    "energies",
    "correspondence",
)
HERE = Path(__file__).resolve().parents[1]
LONGEST_S = 240.0
OPERATORS = {ast.Add: ("+", "-"), ast.Sub: ("-", "+"), ast.Lt: ("<", ">"), ast.Gt: (">", "<")}
OPERATORS |= {ast.LtE: ("<=", ">="), ast.GtE: (">=", "<=")}
NAMES = {"minimum": "maximum", "maximum": "minimum", "argmin": "argmax", "argmax": "argmin", "min": "max", "max": "min"}
SIDES = {"_L": "_R", "_R": "_L", "L": "R", "R": "L", "left": "right", "right": "left"}


@dataclass(frozen=True)
class Mutant:
    """One wrong change: bytes of a file and what stands in their place."""

    file: Path  # below the repository
    line: int
    start: int
    end: int
    instead: bytes

    def applied(self, source: bytes) -> bytes:
        return source[: self.start] + self.instead + source[self.end :]


def mutants(file: Path) -> Iterator[Mutant]:
    """All of a file; `file` below the repository."""
    source = (HERE / file).read_bytes()
    starts = [0]
    for row in source.split(b"\n"):
        starts.append(starts[-1] + len(row) + 1)
    tree = ast.parse(source)
    left_out = _texts_and_types(tree)

    def change(node: ast.expr, start: int, end: int, instead: bytes) -> Mutant:
        return Mutant(file, node.lineno, start, end, instead)

    for node in ast.walk(tree):
        if not isinstance(node, ast.expr) or node in left_out:
            continue
        start = starts[node.lineno - 1] + node.col_offset
        end = starts[node.end_lineno - 1] + node.end_col_offset
        text = source[start:end]
        match node:
            case ast.BinOp(left=left, op=op, right=right) | ast.Compare(left=left, ops=[op], comparators=[right]):
                if type(op) not in OPERATORS:
                    continue
                before, after = (sign.encode() for sign in OPERATORS[type(op)])
                first = starts[left.end_lineno - 1] + left.end_col_offset
                last = starts[right.lineno - 1] + right.col_offset
                at = source.find(before, first, last)
                yield change(node, at, at + len(before), after)
            case ast.UnaryOp(op=ast.USub()):
                yield change(node, start, start + 1, b"")
            case ast.Constant(value=float()) | ast.Constant(value=int()) if not isinstance(node.value, bool):
                if node.value not in (0, 1, -1, 2, 3) or (isinstance(node.value, float) and node.value):
                    yield change(node, start, end, b"(2 * " + text + b")")
            case ast.Constant(value=str() as word) if word.endswith(("_L", "_R")) or word in SIDES:
                ending = word if word in SIDES else word[-2:]
                yield change(node, start, end, repr(word.removesuffix(ending) + SIDES[ending]).encode())
            case ast.Attribute(attr="T"):
                yield change(node, end - 2, end, b"")
            case ast.Attribute(attr=name) if name in NAMES:
                yield change(node, end - len(name), end, NAMES[name].encode())


def _texts_and_types(tree: ast.Module) -> set[ast.AST]:
    """What is no number nor side of a computation: docstrings, annotations, indices, texts with values in them."""
    found: set[ast.AST] = set()
    for node in ast.walk(tree):
        parts = [getattr(node, "annotation", None), getattr(node, "returns", None)]
        parts += [node.value] if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) else []
        parts += [node.slice] if isinstance(node, ast.Subscript) else []
        parts += [node] if isinstance(node, ast.JoinedStr) else []
        found |= {below for part in parts if part is not None for below in ast.walk(part)}
    return found


def survives(mutant: Mutant, copy: Path, room: str) -> bool:
    """Whether the room's tests pass with it."""
    file = copy / mutant.file
    source = file.read_bytes()
    module = ".".join(mutant.file.with_suffix("").parts[1:])
    tests = sorted((copy / "tests" / room).rglob("test_*.py"))
    named = [test for test in tests if module in test.read_text()]
    try:
        file.write_bytes(mutant.applied(source))
        return all(_pass(some, copy) for some in (named, [test for test in tests if test not in named]) if some)
    finally:
        file.write_bytes(source)


def _pass(tests: list[Path], copy: Path) -> bool:
    command = [sys.executable, "-B", "-m", "pytest", "-q", "-x", *map(str, tests)]
    surroundings = os.environ | {"PYTHONPATH": str(copy / "server"), "OPENBLAS_NUM_THREADS": "1"}
    try:
        return not subprocess.run(
            command, cwd=copy, env=surroundings, capture_output=True, timeout=LONGEST_S
        ).returncode
    except subprocess.TimeoutExpired:
        return False


def main() -> int:
    """Prints each survivor; 0 when there is none."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument(
        "rooms", nargs="*", default=ROOMS, metavar="ROOM", help="rooms, or files below server/breastrig"
    )
    parser.add_argument("--count", type=int, default=40, help="how many of all mutants are tried")
    parser.add_argument("--seed", type=int, default=0, help="which ones")
    options = parser.parse_args()
    package = Path("server/breastrig")
    places = [HERE / package / room for room in options.rooms]
    files = sorted(file for place in places for file in (place.rglob("*.py") if place.is_dir() else [place]))
    found = [mutant for file in files for mutant in mutants(file.relative_to(HERE))]
    chosen = random.Random(options.seed).sample(found, min(options.count, len(found)))
    alive = 0
    with tempfile.TemporaryDirectory(prefix="mutants-") as folder:
        copy = Path(folder)
        for name in ("server", "tests", "model_assets"):
            shutil.copytree(HERE / name, copy / name, symlinks=True)
        shutil.copy(HERE / "pyproject.toml", copy)
        for mutant in chosen:
            if survives(mutant, copy, mutant.file.relative_to(package).parts[0]):
                alive += 1
                row = mutant.applied((HERE / mutant.file).read_bytes()).split(b"\n")[mutant.line - 1]
                sys.stdout.write(f"survives: {mutant.file}:{mutant.line}: {row.decode().strip()}\n")
                sys.stdout.flush()
    sys.stdout.write(f"{len(chosen) - alive} of {len(chosen)} wrong changes were seen ({len(found)} are possible).\n")
    return 1 if alive else 0


if __name__ == "__main__":
    sys.exit(main())
