"""Finds what the package says to people, and brings the catalogues up to date: python server/packaging/messages.py

Sentences are written where they are raised, as literals, f-strings, constants with `.format`, or by small functions.
They are found in the syntax tree: what errors of the package and `refuse` are given, and every other literal that looks
like a sentence.  Alternatives become messages of their own ("a {'b' if c else 'd'}" is two), other values places: {0},
or {0:.1f} where a number is written so.  Words alone (table heads, labels, names of landmarks) are in
words.txt; the package must say each.

A new msgid comes into each breastrig.po without a translation, one that nobody says any more leaves it.
"""

import ast
import itertools
import json
import re
import tomllib
from collections import defaultdict
from dataclasses import dataclass, field
from pathlib import Path

import polib
from pydantic_core._pydantic_core import list_all_errors

PACKAGE = Path(__file__).resolve().parents[1] / "breastrig"
CATALOGUES = PACKAGE / "languages"
WORDS = Path(__file__).with_name("words.txt")
MODEL = PACKAGE.parents[1] / "model_assets" / "built" / "torso.json"
TEMPLATES = [each["message_template_python"] for each in list_all_errors()]
PYDANTIC = [text.replace("{expected_plural}", end) for text in TEMPLATES for end in ("", "s")]
# The command line, what starts a service and owners of rigs are addressed in English; `index` has SQL.
ENGLISH_ONLY = ("cli", "batch", "execution", "index", "languages", "__main__.py", "__init__.py", "api/settings.py")
ENGLISH_ONLY += ("api/config.py", "api/web_server.py", "api/metrics.py", "api/openapi.py", "api/trusted_proxy.py")
ENGLISH_ONLY += (
    "api/routes/docs.py",
    "core/settings_file.py",
    "rig",
    "gltf/read_rig.py",
    "gltf/side_file.py",
    "storage/data_folder.py",
)
ENGLISH_ONLY += (
    "core/output_files.py",
    "core/private_files.py",
    "use/folder/cohort.py",
    "geometry",
    "least_squares/problem.py",
)
ENGLISH_ONLY += (
    "core/settings_file.py",
    "gltf/skinned.py",
    "api/people/people.py",
    "least_squares/problem.py",
    "least_squares/quadratic_program.py",
    "archive/objects.py",
    "archive/slicer.py",
    "archive/measurements.py",
)  # DICOM's own words
# Where every text of two words is said, if only in another one.
ALL_SAID = ("fitting/verdicts", "fitting/picks", "fitting/hypotheses.py", "fitting/body/trunk_lengths.py")
ALL_SAID += ("drawings/inside", "drawings/handles", "drawings/constructions", "drawings/patterns.py")
ALL_SAID += ("drawings/on_skin.py", "drawings/plan_on_scan.py", "report/pages", "report/guides", "report/table.py")
ALL_SAID += ("report/bands.py", "report/measures.py", "report/ptosis.py", "report/symmetry.py", "report/volume.py")
ALL_SAID += ("report/visits/series.py", "report/visits/symmetry.py")
ALL_SAID += ("use/folder/one_body.py", "use/folder/whose.py", "use/lines", "use/steps", "colour/features")
ALL_SAID += (
    "scan/images",
    "scan/volumes",
    "scan/orient.py",
    "scan/formats/gltf",
    "scan/formats/off.py",
    "scan/units.py",
)
ALL_SAID += ("core/glb.py", "core/gltf_arrays.py", "core/errors.py", "service", "api/place_checks.py")
TERMS = ("scan/volumes/grids/nrrd.py", "scan/volumes/codes.py")
NOT_SAID = {"doc", "Field", "compile", "warn", "getLogger", "APIBlueprint", "output", "debug", "info", "warning"}
NOT_SAID |= {"error", "exception", "execute", "executescript", "ValueError_", "StructureError", "AssertionError"}
KEYWORDS_NOT_SAID = {"description", "help", "metavar", "responses", "summary", "tag"}
SENTENCE = re.compile(
    r"""["“]?(?:[A-Z{][^\n]*[^\n.?!:] [^\n]* [^\n]*[.?!]|[A-Z][\w'’-]+ [\w'’{}-]+ [\w'’{}-]+ [^\n]*)$"""
)
MOST = 16  # alternatives of one sentence
PLACE = re.compile(r"\{([^{}:!]*)(?:![rs])?(:[^{}]*)?\}")
FIELD = re.compile(r"\{\w*(?::[^{}]*)?\}")  # of a text for format()
Texts = list[str]
WORDLESS = (ast.Name, ast.expr_context, ast.operator, ast.cmpop, ast.alias)


@dataclass
class Module:
    """One module's tree, with what its names stand for."""

    path: Path
    tree: ast.Module
    constants: dict[str, ast.expr] = field(default_factory=dict)
    functions: dict[str, ast.FunctionDef] = field(default_factory=dict)
    imports: dict[str, tuple[str, str]] = field(default_factory=dict)  # module, name

    @property
    def name(self) -> str:
        return self.path.relative_to(PACKAGE).as_posix()


def read_module(path: Path) -> Module:
    module = Module(path, ast.parse(path.read_text("utf-8")))
    for node in module.tree.body:
        if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name):
            module.constants[node.targets[0].id] = node.value
        elif isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name) and node.value is not None:
            module.constants[node.target.id] = node.value
    for each in module.tree.body:
        if isinstance(each, ast.FunctionDef):
            module.functions[each.name] = each
        elif isinstance(each, ast.ImportFrom) and (each.module or "").startswith("breastrig"):
            module.imports |= {one.asname or one.name: (str(each.module), one.name) for one in each.names}
    return module


class Package:
    """All modules, and the texts of their expressions."""

    def __init__(self) -> None:
        self._modules: dict[Path, Module] = {}
        self.errors = {"BadManifest", "refuse", "problem", "Changed", "Reason", "explained"}
        self._assignments: dict[ast.AST, dict[str, list[ast.AST]]] = {}
        self._arguments: dict[ast.AST, set[str]] = {}
        self.pending: Texts = []  # alternatives that became messages of their own
        self.found: dict[str, set[str]] = defaultdict(set)  # msgid: modules
        tree = self.read(PACKAGE / "core" / "errors.py").tree
        self.errors |= {node.name for node in tree.body if isinstance(node, ast.ClassDef)}

    def read(self, path: Path) -> Module:
        if path not in self._modules:
            self._modules[path] = read_module(path)
        return self._modules[path]

    def of(self, dotted: str) -> Module | None:
        place = PACKAGE.parent / Path(*dotted.split("."))
        file = place.with_suffix(".py")
        return self.read(file) if file.is_file() else None

    def texts(self, node: ast.expr, module: Module, scope: ast.AST | None, depth: int = 0) -> Texts | None:
        """All texts that an expression can be, with places; None where it is not known."""
        if depth > 8:
            return None
        match node:
            case ast.Constant(value=str() as text):
                is_form = FIELD.search(text) and not set("{}") & set(FIELD.sub("", text))
                return [text if is_form else text.replace("{", "{{").replace("}", "}}")]
            case ast.JoinedStr(values=values):
                return self._joined([self._part(each, module, scope, depth) for each in values])
            case ast.BinOp(left=left, op=ast.Add(), right=right):
                return self._joined([self.texts(one, module, scope, depth + 1) or ["{}"] for one in (left, right)])
            case ast.IfExp(body=body, orelse=orelse):
                return self._either([body, orelse], module, scope, depth)
            case ast.BoolOp(values=values):
                return self._either(values, module, scope, depth)
            case ast.Name(id=name):
                return self._name(name, module, scope, depth)
            case ast.Subscript(value=ast.Name(id=name), slice=key):
                return self._item(name, key, module, scope, depth)
            case ast.Call(func=ast.Attribute(value=value, attr="format")):
                return self.texts(value, module, scope, depth + 1)
            case ast.Call(func=ast.Attribute(value=value, attr="rstrip" | "removesuffix" | "capitalize" | "lstrip")):
                return self.texts(value, module, scope, depth + 1)
            case ast.Call(func=ast.Name(id=name)):
                return self._returned(name, module, depth)
        return None

    def _either(self, nodes: list[ast.expr], module: Module, scope: ast.AST | None, depth: int) -> Texts | None:
        found = [self.texts(each, module, scope, depth + 1) for each in nodes]
        return None if None in found else [text for each in found for text in each or []]

    def _part(self, node: ast.expr, module: Module, scope: ast.AST | None, depth: int) -> Texts:
        if not isinstance(node, ast.FormattedValue):
            return self.texts(node, module, scope, depth) or ["{}"]
        if node.format_spec is not None:
            spec = ast.unparse(node.format_spec)[2:-1]
            return ["{:g}" if "{" in spec else "{:" + spec + "}"]
        return self.texts(node.value, module, scope, depth + 1) or ["{}"]

    def _joined(self, parts: list[Texts]) -> Texts:
        """All combinations; beyond MOST the longest alternatives become places, and messages of their own."""
        while len(parts) > 1 and _product(parts) > MOST:
            widest = max(range(len(parts)), key=lambda k: len(parts[k]))
            self.pending += [each for each in parts[widest] if len(each) > 1]
            parts[widest] = ["{}"]
        return ["".join(each) for each in itertools.product(*parts)]

    def _name(self, name: str, module: Module, scope: ast.AST | None, depth: int) -> Texts | None:
        if scope is not None:
            if known := self._assigned(scope).get(name):
                values = [each.value for each in known if isinstance(each, ast.Assign | ast.NamedExpr | ast.AnnAssign)]
                if len(values) != len(known) or any(each is None for each in values):
                    return None
                return self._either([each for each in values if each is not None], module, scope, depth)
            if name in self._arguments[scope]:
                return None
        if name in module.constants:
            return self.texts(module.constants[name], module, None, depth + 1)
        if name in module.imports:
            dotted, original = module.imports[name]
            other = self.of(dotted)
            return None if other is None else self._name(original, other, None, depth + 1)
        return None

    def _assigned(self, scope: ast.AST) -> dict[str, list[ast.AST]]:
        """What a function gives its names, once for each."""
        if scope not in self._assignments:
            found = self._assignments[scope] = defaultdict(list)
            self._arguments[scope] = set()
            for each in ast.walk(scope):
                for name in _targets(each):
                    found[name].append(each)
                if isinstance(each, ast.arg):
                    self._arguments[scope].add(each.arg)
        return self._assignments[scope]

    def _item(self, name: str, key: ast.expr, module: Module, scope: ast.AST | None, depth: int) -> Texts | None:
        """One of the values of a table."""
        node = module.constants.get(name)
        if node is None and name in module.imports:
            dotted, original = module.imports[name]
            other = self.of(dotted)
            return None if other is None else self._item(original, key, other, None, depth + 1)
        if isinstance(node, ast.Dict):
            if isinstance(key, ast.Constant):
                pairs = [
                    v for k, v in zip(node.keys, node.values, strict=True) if getattr(k, "value", None) == key.value
                ]
                return self._either(pairs, module, None, depth) if pairs else None
            return self._either(node.values, module, None, depth)
        return None

    def _returned(self, name: str, module: Module, depth: int) -> Texts | None:
        if name in module.imports:
            dotted, original = module.imports[name]
            other = self.of(dotted)
            return None if other is None else self._returned(original, other, depth + 1)
        function = module.functions.get(name)
        if function is None:
            return None
        returned = [each.value for each in ast.walk(function) if isinstance(each, ast.Return)]
        if not returned or any(each is None for each in returned):
            return None
        return self._either([each for each in returned if each is not None], module, function, depth + 1)

    def collect(self) -> None:
        """Fills `found`."""
        for path in sorted(PACKAGE.rglob("*.py")):
            if not path.relative_to(PACKAGE).as_posix().startswith(ENGLISH_ONLY):
                module = self.read(path)
                self._look(module.tree, module, None)

    def _look(self, node: ast.AST, module: Module, scope: ast.AST | None) -> None:
        if isinstance(node, ast.FunctionDef):
            if node.name == "__repr__":
                return
            scope, node.returns = node, None
        if isinstance(node, ast.arg):
            return
        if isinstance(node, ast.AnnAssign):
            node.annotation = ast.Constant(None)
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            return  # a docstring
        if isinstance(node, ast.Assert):
            return self._look(node.test, module, scope)
        if isinstance(node, ast.Call):
            called = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
            if called in self.errors:
                for each in node.args:
                    self._take(each, module, scope, every=True)
            elif called == "Field" and module.name.startswith("drawings/constructions"):  # forms of patterns
                for one in node.keywords:
                    if one.arg in ("title", "description"):
                        self._take(one.value, module, scope, every=True)
                return None
            elif called in NOT_SAID:
                return None
            node.keywords = [each for each in node.keywords if each.arg not in KEYWORDS_NOT_SAID]
        if isinstance(node, ast.Constant | ast.JoinedStr | ast.BinOp):
            self._take(node, module, scope, every=False)
            if isinstance(node, ast.Constant):
                return None
        if isinstance(node, ast.Dict):
            both = zip(node.keys, node.values, strict=True)
            kept = [(key, value) for key, value in both if getattr(key, "value", None) not in KEYWORDS_NOT_SAID]
            node.keys, node.values = [key for key, _ in kept], [value for _, value in kept]
        for child in ast.iter_child_nodes(node):
            if not isinstance(child, WORDLESS) and not (
                isinstance(node, ast.JoinedStr) and isinstance(child, ast.Constant)
            ):
                self._look(child, module, scope)
        return None

    def _take(self, node: ast.expr, module: Module, scope: ast.AST | None, *, every: bool) -> None:
        if isinstance(node, ast.Tuple):
            for each in node.elts:
                self._take(each, module, scope, every=every)
            return
        self.pending = []
        for text in [*(self.texts(node, module, scope) or []), *self.pending]:
            msgid = numbered(text)
            words = re.findall("[a-zA-Z]{2,}", PLACE.sub("", msgid))
            is_said = every or (
                module.name.startswith(ALL_SAID)
                and module.name not in TERMS
                and " " in msgid.strip()
                and len(words) > 1
            )
            if words and (is_said or SENTENCE.match(msgid)):
                self.found[msgid].add(module.name)


def _targets(node: ast.AST) -> set[str]:
    """The names that a statement assigns."""
    targets = node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", None)]
    names = (each for target in targets if target is not None for each in ast.walk(target))
    return {each.id for each in names if isinstance(each, ast.Name)}


def _product(parts: list[Texts]) -> int:
    total = 1
    for each in parts:
        total *= len(each)
    return total


def numbered(text: str) -> str:
    """The text with its places numbered from 0, in their order; a field that stands twice is two places."""
    count = itertools.count()
    kept = text.replace("{{", "\x00").replace("}}", "\x01")
    kept = PLACE.sub(lambda found: f"{{{next(count)}{found[2] or ''}}}", kept)
    return kept.replace("\x00", "{{").replace("\x01", "}}")


def words() -> dict[str, set[str]]:
    """The words of words.txt that something says."""
    files = [
        *PACKAGE.rglob("*.py"),
        *PACKAGE.rglob("*.typ"),
        *PACKAGE.rglob("*.html"),
        MODEL,
        *MODEL.parent.rglob("drawings/*.json"),
    ]
    text = "\n".join([*(path.read_text("utf-8") for path in files), *PYDANTIC])
    text += text.replace("_", " ")  # names, as they are read out
    asked = (line for line in WORDS.read_text("utf-8").splitlines() if line and not line.startswith("# "))
    parts = {word: [part.strip() for part in FIELD.split(word)] for word in asked}
    return {word: {WORDS.name} for word, found in parts.items() if all(part in text for part in found)}


def update(language: str, found: dict[str, set[str]]) -> tuple[list[str], list[str]]:
    """Brings one catalogue up to date, in memory; the msgids that came and those that went."""
    catalogue = polib.pofile(str(CATALOGUES / language / "LC_MESSAGES" / "breastrig.po"), wrapwidth=100)
    known = {entry.msgid: entry for entry in catalogue}
    gone = [msgid for msgid in known if msgid not in found]
    come = [msgid for msgid in found if msgid not in known]
    for msgid in gone:
        catalogue.remove(known[msgid])
    for msgid in come:
        catalogue.append(polib.POEntry(msgid=msgid))
    for entry in catalogue:
        entry.occurrences = [(place, "") for place in sorted(found[entry.msgid])[:3]]
    catalogue.sort(key=lambda entry: (entry.occurrences, entry.msgid))
    catalogue.save()
    return come, gone


def of_the_model() -> dict[str, set[str]]:
    """Labels and definitions of the model's side file, and the facts of its verdict."""
    found: dict[str, set[str]] = defaultdict(set)
    side = json.loads(MODEL.read_text("utf-8"))
    for each in (*side["landmarks"], *side["drawings"], *side["lengths"]):
        for key in ("label", "definition"):
            if key in each:
                found[each[key]].add(MODEL.name)
    for file in MODEL.parent.rglob("drawings/*.json"):
        drawing = json.loads(file.read_text("utf-8"))
        for label in (drawing["label"], *(shape["label"] for shape in drawing["shapes"])):
            found[label].add(file.name)
    for file in MODEL.parent.rglob("*.known/verdict.toml"):
        for signal in tomllib.loads(file.read_text("utf-8"))["signals"].values():
            found[numbered(signal["fact"])].add(file.name)
    return found


def all_msgids() -> dict[str, set[str]]:
    """Every msgid with the modules that say it."""
    package = Package()
    package.collect()
    return {**package.found, **of_the_templates(), **of_the_model(), **words()}


def of_the_templates() -> dict[str, set[str]]:
    """The words of pages, t("word")."""
    return {
        word: {path.name}
        for path in (*PACKAGE.rglob("*.typ"), *PACKAGE.rglob("*.html"))
        for word in re.findall(r't\("([^"]+)"\)', path.read_text("utf-8"))
    }


if __name__ == "__main__":
    msgids = all_msgids()
    for path in sorted(CATALOGUES.glob("*/LC_MESSAGES/breastrig.po")):
        language = path.parents[1].name
        come, gone = update(language, msgids)
        print(f"{language}: {len(msgids)} messages, {len(come)} came, {len(gone)} went")
