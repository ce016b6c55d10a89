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
import re
from collections import defaultdict
from dataclasses import dataclass, field
from pathlib import Path

import polib
from pydantic_core._pydantic_core import list_all_errors

PACKAGE = Path(__file__).resolve().parents[1] / "breastrig"
CATALOGUES = PACKAGE / "languages"
WORDS = Path(__file__).with_name("words.txt")
MODEL = PACKAGE.parents[1] / "model_assets" / "built" / "torso.json"
PYDANTIC = [each["message_template_python"] for each in list_all_errors()]
# The command line, what starts a service and owners of rigs are addressed in English; `index` has SQL.
ENGLISH_ONLY = ("cli", "batch", "execution", "index", "languages", "__main__.py", "__init__.py", "api/settings.py")
ENGLISH_ONLY += ("api/config.py", "api/web_server.py", "api/metrics.py", "api/openapi.py", "api/trusted_proxy.py")
ENGLISH_ONLY += ("api/routes/docs.py", "rig", "gltf/read_rig.py", "gltf/side_file.py", "storage/data_folder.py")
ENGLISH_ONLY += ("core/output_files.py", "core/private_files.py", "use/folder/cohort.py", "least_squares", "geometry")
ENGLISH_ONLY += ("gltf/skinned.py",)
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
    for each in ast.walk(module.tree):
        if isinstance(each, ast.FunctionDef):
            module.functions.setdefault(each.name, each)
        elif isinstance(each, ast.ImportFrom) and (each.module or "").startswith("breastrig"):
            module.imports |= {one.asname or one.name: (str(each.module), one.name) for one in each.names}
    return module


class Package:
    """All modules, and the texts of their expressions."""

    def __init__(self) -> None:
        self.modules = {path: read_module(path) for path in sorted(PACKAGE.rglob("*.py"))}
        self.errors = {"BadManifest", "refuse", "problem", "Changed"}
        self.pending: Texts = []  # alternatives that became messages of their own
        self.found: dict[str, set[str]] = defaultdict(set)  # msgid: modules
        tree = self.modules[PACKAGE / "core" / "errors.py"].tree
        self.errors |= {node.name for node in tree.body if isinstance(node, ast.ClassDef)}

    def of(self, dotted: str) -> Module | None:
        place = PACKAGE.parent / Path(*dotted.split("."))
        return self.modules.get(place.with_suffix(".py")) or self.modules.get(place / "__init__.py")

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
            known = [each for each in ast.walk(scope) if _assigns(each, name)]
            if known:
                values = [each.value for each in known if isinstance(each, ast.Assign | ast.NamedExpr | ast.AnnAssign)]
                if len(values) != len(known) or any(each is None for each in values):
                    return None
                return self._either([each for each in values if each is not None], module, scope, depth)
            arguments = [each.arg for each in ast.walk(scope) if isinstance(each, ast.arg)]
            if name in arguments:
                return None
        if name in module.constants:
            return self.texts(module.constants[name], module, None, depth + 1)
        if name in module.imports:
            dotted, original = module.imports[name]
            other = self.of(dotted)
            return None if other is None else self._name(original, other, None, depth + 1)
        return None

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
        for module in self.modules.values():
            if not module.name.startswith(ENGLISH_ONLY):
                self._look(module.tree, module, None)

    def _look(self, node: ast.AST, module: Module, scope: ast.AST | None) -> None:
        if isinstance(node, ast.FunctionDef):
            scope = node
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            return  # a docstring
        if isinstance(node, ast.Assert):
            return self._look(node.test, module, scope)
        if isinstance(node, ast.Call):
            called = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
            if called in self.errors:
                for each in node.args:
                    self._take(each, module, scope, every=True)
            elif called in NOT_SAID:
                return None
            node.keywords = [each for each in node.keywords if each.arg not in KEYWORDS_NOT_SAID]
        if isinstance(node, ast.Constant | ast.JoinedStr | ast.BinOp):
            self._take(node, module, scope, every=False)
            if isinstance(node, ast.Constant):
                return None
        if isinstance(node, ast.Dict):
            both = zip(node.keys, node.values, strict=True)
            node.values = [value for key, value in both if getattr(key, "value", None) not in KEYWORDS_NOT_SAID]
            node.keys = []
        for child in ast.iter_child_nodes(node):
            if not (isinstance(node, ast.JoinedStr) and isinstance(child, ast.Constant)):
                self._look(child, module, scope)
        return None

    def _take(self, node: ast.expr, module: Module, scope: ast.AST | None, *, every: bool) -> None:
        self.pending = []
        for text in [*(self.texts(node, module, scope) or []), *self.pending]:
            msgid = numbered(text)
            if len(re.findall("[a-zA-Z]{2,}", PLACE.sub("", msgid))) and (every or SENTENCE.match(msgid)):
                self.found[msgid].add(module.name)


def _assigns(node: ast.AST, name: str) -> bool:
    targets = node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", None)]
    return any(
        isinstance(each, ast.Name) and each.id == name for target in targets if target for each in ast.walk(target)
    )


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
    """The words of words.txt with what says them; none for those that nobody says any more."""
    said: dict[str, set[str]] = defaultdict(set)
    asked = [line for line in WORDS.read_text("utf-8").splitlines() if line and not line.startswith("# ")]
    files = [*PACKAGE.rglob("*.py"), *PACKAGE.rglob("*.toml"), *PACKAGE.rglob("*.typ"), MODEL]
    texts = {path: path.read_text("utf-8") for path in files if not path.is_relative_to(CATALOGUES)}
    for word in asked:
        parts = [part for part in FIELD.split(word) if part.strip()]
        places = {path.name for path, text in texts.items() if all(part in text for part in parts)}
        said[word] |= places or {"pydantic" for text in PYDANTIC if all(part in text for part in parts)}
    return said


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


def all_msgids() -> dict[str, set[str]]:
    """Every msgid with the modules that say it."""
    package = Package()
    package.collect()
    return {**package.found, **words()}


if __name__ == "__main__":
    msgids = all_msgids()
    for path in sorted(CATALOGUES.glob("*/LC_MESSAGES/breastrig.po")):
        language = path.parents[1].name
        come, gone = update(language, msgids)
        print(f"{language}: {len(msgids)} messages, {len(come)} came, {len(gone)} went")
