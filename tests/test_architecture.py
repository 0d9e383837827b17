"""The house's rule of dependency, read from the source (docs/architecture.md). Every import counts: those in
functions and under TYPE_CHECKING too."""

from __future__ import annotations

import ast
import os
import re
import subprocess
import sys
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from importlib import import_module, metadata
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGES = ("cartgrasp", "estimation", "planning")
COMPOSITION_ROOT = ("cartgrasp.cli", "cartgrasp.studies")
BY_DEFAULT = {("planning.control.default_filter", "estimation")}  # late, and known by its role alone
DOOR = "cartgrasp.__main__"  # starts the command line, so it may import cartgrasp.cli
LONGEST = 400

FORBIDDEN_MODULES = ("pickle", "cPickle", "dill", "cloudpickle", "joblib", "marshal", "shelve", "yaml")
ALLOWED_MODULES = {"cartgrasp.studies.campaigns.workers": ("joblib",)}  # for its processes; it reads no file
FORBIDDEN_CALLS = ("eval", "exec", "__import__")
FORBIDDEN_KEYWORDS = (("allow_pickle", True), ("typ", "unsafe"))
HEAVY = ("numpy", "pydantic", "ruamel", "mujoco", "matplotlib", "cvxpy", "scipy", "numba", "pinocchio")


@dataclass(frozen=True)
class Import:
    """An import of ours by one of ours. It is `hidden` in a function or under TYPE_CHECKING."""

    importer: str
    imported: str
    line: int
    hidden: bool

    def __str__(self) -> str:
        return f"{self.importer}:{self.line} imports {self.imported}"


def sources(root: Path = ROOT) -> dict[str, str]:
    """Source by module name; a package is called by its own name."""
    found = {}
    for package in PACKAGES:
        for path in sorted((root / package).rglob("*.py")):
            name = ".".join(path.relative_to(root).with_suffix("").parts)
            found[name.removesuffix(".__init__") + (":package" if path.name == "__init__.py" else "")] = (
                path.read_text()
            )
    return found


def imports(tree_of: Mapping[str, str]) -> list[Import]:
    """`tree_of` gives source by module name, with `:package` behind the name of a package."""
    known = {name.removesuffix(":package") for name in tree_of}
    found = []
    for name, source in tree_of.items():
        importer = name.removesuffix(":package")
        package = importer if name.endswith(":package") else importer.rpartition(".")[0]
        for node, hidden in _statements(ast.parse(source), False):
            for target in _targets(node, package, known):
                if target.split(".")[0] in PACKAGES and target != importer:
                    found.append(Import(importer, target, node.lineno, hidden))
    return found


def _statements(node: ast.AST, hidden: bool) -> Iterator[tuple[ast.Import | ast.ImportFrom, bool]]:
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.Import | ast.ImportFrom):
            yield child, hidden
        elif isinstance(child, ast.Call) and ast.unparse(child.func).endswith("import_module"):
            names = [a.value for a in child.args[:1] if isinstance(a, ast.Constant) and isinstance(a.value, str)]
            yield ast.Import([ast.alias(name) for name in names], lineno=child.lineno), hidden
        elif isinstance(child, ast.If) and ast.unparse(child.test) in (
            "TYPE_CHECKING",
            "typing.TYPE_CHECKING",
        ):
            for part in child.body:
                yield from _statements(ast.Module([part], []), True)
            for part in child.orelse:
                yield from _statements(ast.Module([part], []), hidden)
        else:
            inside = isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda)
            yield from _statements(child, hidden or inside)


def _targets(node: ast.Import | ast.ImportFrom, package: str, known: set[str]) -> list[str]:
    """Modules that a statement names: of `from a import b` it is a.b where that is a module, else a."""
    if isinstance(node, ast.Import):
        return [alias.name for alias in node.names]
    base = node.module or ""
    if node.level:
        above = package.split(".")[: len(package.split(".")) - node.level + 1]
        base = ".".join([*above, *([base] if base else [])])
    return [f"{base}.{alias.name}" if f"{base}.{alias.name}" in known else base for alias in node.names]


def _inside(module: str, rooms: tuple[str, ...]) -> bool:
    return any(module == room or module.startswith(room + ".") for room in rooms)


def forbidden_arrows(found: list[Import]) -> list[str]:
    wrong = []
    for arrow in found:
        from_root, to_root = (
            _inside(arrow.importer, COMPOSITION_ROOT),
            _inside(arrow.imported, COMPOSITION_ROOT),
        )
        package, other = arrow.importer.split(".")[0], arrow.imported.split(".")[0]
        if to_root and not from_root and not (arrow.importer == DOOR and _inside(arrow.imported, ("cartgrasp.cli",))):
            wrong.append(f"{arrow}: nothing imports the composition root")
        elif arrow.hidden and (arrow.importer, arrow.imported) in BY_DEFAULT:
            continue
        elif not from_root and package != other and other != "cartgrasp":
            wrong.append(f"{arrow}: {package} does not know {other}")
    return wrong


def circles(found: list[Import], with_hidden: bool) -> list[list[str]]:
    """Sets of modules that reach one another (Tarjan's components of more than one module), sorted."""
    graph: dict[str, set[str]] = {}
    for arrow in found:
        graph.setdefault(arrow.importer, set())
        graph.setdefault(arrow.imported, set())
        if with_hidden or not arrow.hidden:
            graph[arrow.importer].add(arrow.imported)
    reach: dict[str, set[str]] = {}
    for start in graph:
        seen, waiting = set(), list(graph[start])
        while waiting:
            module = waiting.pop()
            if module not in seen:
                seen.add(module)
                waiting.extend(graph[module])
        reach[start] = seen
    members = {tuple(sorted({m for m in reach[s] if s in reach[m]})) for s in graph if s in reach[s]}
    return sorted(list(group) for group in members)


def unsafe(tree_of: Mapping[str, str]) -> list[str]:
    """What would run code that came as data."""
    wrong = []
    for name, source in tree_of.items():
        for node in ast.walk(ast.parse(source)):
            names = []
            if isinstance(node, ast.Import):
                names = [alias.name.split(".")[0] for alias in node.names]
            elif isinstance(node, ast.ImportFrom) and not node.level:
                names = [(node.module or "").split(".")[0]]
            allowed = ALLOWED_MODULES.get(name, ())
            wrong += [f"{name}:{node.lineno} imports {n}" for n in names if n in FORBIDDEN_MODULES and n not in allowed]
            if isinstance(node, ast.Call):
                if isinstance(node.func, ast.Name) and node.func.id in FORBIDDEN_CALLS:
                    wrong.append(f"{name}:{node.lineno} calls {node.func.id}")
                for keyword in node.keywords:
                    value = keyword.value.value if isinstance(keyword.value, ast.Constant) else None
                    if (keyword.arg, value) in FORBIDDEN_KEYWORDS:
                        wrong.append(f"{name}:{node.lineno} says {keyword.arg}={value!r}")
    return wrong


def fragments(tree_of: Mapping[str, str]) -> list[str]:
    """Docstrings, and strings below constants, that leave out what they are of."""
    return [
        f"{module}:{node.lineno}"
        for module, source in tree_of.items()
        for node in ast.walk(ast.parse(source))
        if isinstance(node, ast.Expr)
        and isinstance(node.value, ast.Constant)
        and isinstance(node.value.value, str)
        and node.value.value.startswith("Of ")
    ]


def ambiguous(tree_of: Mapping[str, str]) -> dict[str, list[str]]:
    """Names of constants that are one number here and another there, with the modules that define them."""
    values: dict[str, dict[str, set[str]]] = {}
    for module, source in tree_of.items():
        for name, value in _numbers(ast.parse(source)):
            values.setdefault(name, {}).setdefault(value, set()).add(module)
    return {name: sorted(set().union(*found.values())) for name, found in values.items() if len(found) > 1}


def _numbers(tree: ast.Module) -> Iterator[tuple[str, str]]:
    """A module's constants that are numbers, or tuples and products of some, with their values."""
    for statement in tree.body:
        if not isinstance(statement, ast.Assign):
            continue
        for target in statement.targets:
            names = target.elts if isinstance(target, ast.Tuple) else [target]
            several = isinstance(target, ast.Tuple) and isinstance(statement.value, ast.Tuple)
            values = statement.value.elts if several else [statement.value] * len(names)  # type: ignore[attr-defined]
            for name, value in zip(names, values, strict=False):
                if isinstance(name, ast.Name) and name.id.isupper() and _is_number(value):
                    yield name.id, ast.unparse(value)


def _is_number(value: ast.expr) -> bool:
    match value:
        case ast.Constant(value=number):
            return isinstance(number, (int, float))
        case ast.UnaryOp(operand=operand):
            return _is_number(operand)
        case ast.BinOp(left=left, right=right):
            return _is_number(left) and _is_number(right)
        case ast.Tuple(elts=parts):
            return all(map(_is_number, parts))
    return False


def too_long(files: Mapping[str, str]) -> list[str]:
    counts = {name: len(source.splitlines()) for name, source in files.items()}
    return [f"{name}: {count} lines" for name, count in counts.items() if count > LONGEST]


# --- the house ----------------------------------------------------------------------------------------------


@cache
def tree() -> dict[str, str]:
    return sources()


@cache
def arrows() -> list[Import]:
    return imports(tree())


def test_every_room_is_read():
    assert {"cartgrasp.model", "cartgrasp.effects:package", "cartgrasp.effects.effect"} <= set(tree())
    assert any(a.importer == "cartgrasp.model" and a.imported == "cartgrasp.effects" and not a.hidden for a in arrows())
    assert any(a.importer == "cartgrasp.motion" and a.imported == "cartgrasp.model" and a.hidden for a in arrows())


def test_no_arrow_that_the_picture_does_not_have():
    assert not forbidden_arrows(arrows())


def test_no_circle():
    assert not circles(arrows(), with_hidden=False)


def test_hidden_circles_stay_within_a_package():
    """A type or a late import may point back, but not into another package or subpackage."""
    for circle in circles(arrows(), with_hidden=True):
        rooms = {name if f"{name}:package" in tree() else name.rpartition(".")[0] for name in circle}
        assert len(rooms) == 1, circle


@pytest.mark.long
def test_nothing_runs_code_that_came_as_data():
    assert not unsafe(tree())


def test_docstrings_name_what_they_describe():
    assert not fragments(tree())
    assert fragments({"a": 'X = 1\n"""Of a log: its rows."""\n', "b": '"""Rows of a log."""\n'}) == ["a:2"]


def test_the_page_names_what_is_there():
    """Every module that docs/architecture.md names exists, and it names all of `estimation`, of which it tells most."""
    page = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    modules = {path.name for package in PACKAGES for path in (ROOT / package).rglob("*.py")}
    mine = {path.name for path in (ROOT / "estimation").rglob("*.py") if path.name != "__init__.py"}
    told = {Path(name).name for name in re.findall(r"`([\w/.]+\.py)`", page)}
    assert told - modules == {"test_architecture.py"}
    assert {name for name in mine if name not in page} == set()


def test_no_constant_has_two_meanings():
    assert ambiguous(sources()) == {}


def test_no_file_is_too_long():
    """Sources in other languages too: pages, styles, C."""
    kinds = (".py", ".js", ".css", ".html", ".c", ".h")
    paths = [path for package in PACKAGES for path in (ROOT / package).rglob("*") if path.suffix in kinds]
    assert not too_long({str(path.relative_to(ROOT)): path.read_text() for path in paths})


def loaded(program: str) -> list[str]:
    """What a program prints, in a process of its own."""
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", program],
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.split()


@pytest.mark.parametrize("package", PACKAGES)
def test_importing_a_package_is_light(package):
    """Heavy libraries are imported where they are used: `cartgrasp --help` stays under a second."""
    assert loaded(f"import sys, {package}; print(*[m for m in {HEAVY!r} if m in sys.modules])") == []


def test_a_filter_loads_nothing_that_is_for_whole_logs():
    rooms = ("estimation.weak_form", "estimation.discrepancy", "estimation.whole_log")
    program = (
        f"import sys; from estimation import CartFilter; print(*[m for m in sys.modules if m.startswith({rooms!r})])"
    )
    assert loaded(program) == []


@pytest.mark.parametrize("name", [*PACKAGES, "cartgrasp.simulation"])
def test_every_name_of_a_package_is_there(name):
    """None is a module's, too, which would hide it once that is imported; and `dir` shows no other."""
    package = import_module(name)
    held = {name: home for home, names in package._HOMES.items() for name in names.split()}
    assert set(held) == set(package.__all__) == {one for one in dir(package) if not one.startswith("__")}
    for name, home in held.items():
        module = import_module(f"{package.__name__}.{home}")
        assert getattr(package, name) is getattr(module, name)
    with pytest.raises(AttributeError, match="no attribute 'lod_cart'"):
        package.lod_cart  # noqa: B018


@pytest.mark.long
def test_the_dependencies_are_what_is_imported():
    """Beside the tests' runner, which the project's users ask for."""
    declared = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    extras = [name for names in declared["optional-dependencies"].values() for name in names]
    named = {re.split(r"[^\w.-]", line)[0] for line in declared["dependencies"]}
    imported = {
        alias.name if isinstance(node, ast.Import) else str(node.module)
        for package in PACKAGES
        for path in (ROOT / package).rglob("*.py")
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.Import) or (isinstance(node, ast.ImportFrom) and not node.level)
        for alias in node.names
    }
    own = {*sys.stdlib_module_names, *PACKAGES, "compression"}  # which Python 3.14 has
    homes = {name.partition(".")[0] for name in imported} - own
    listed = metadata.packages_distributions()
    used = {distribution for home in homes for distribution in listed.get(home, [home])}
    optional = {re.split(r"[^\w.-]", line)[0] for line in extras}
    assert used - optional <= named | {"mujoco", "pinocchio", "rtbdata"}
    assert named - used == {"pytest"}


# --- the checker bites --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("importer", "source"),
    [
        ("cartgrasp.model", "import estimation"),
        ("cartgrasp.model", "import planning.planner as p"),
        ("cartgrasp.model", "from planning import planner"),
        ("cartgrasp.model", "def f():\n    from estimation.gaussian import Gaussian"),
        ("cartgrasp.model", "async def f():\n    import planning"),
        ("cartgrasp.model", "class A:\n    def f(self):\n        import planning"),
        ("cartgrasp.model", "try:\n    import planning\nexcept ImportError:\n    pass"),
        (
            "cartgrasp.model",
            "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from planning.plan import Plan",
        ),
        ("cartgrasp.model", "import typing\nif typing.TYPE_CHECKING:\n    import estimation"),
        ("cartgrasp.logs.csv", "from ..studies import table1"),
        ("cartgrasp.model", "from . import cli"),
        ("cartgrasp.model", "from .cli import main"),
        ("cartgrasp.__main__", "from .studies import table1"),
        ("estimation.filter", "import planning"),
        ("estimation.filter", "def f():\n    return importlib.import_module('planning.planner')"),
        ("estimation.filter", "from cartgrasp.cli import main"),
        ("planning.plan", "from estimation.gaussian import Gaussian"),
        ("planning.control.default_filter", "from estimation import CartFilter"),
        ("planning.control.controller", "def f():\n    from estimation import CartFilter"),
        ("planning.plan", "def f():\n    import cartgrasp.studies.table1"),
    ],
)
def test_a_forbidden_arrow_is_found(importer, source):
    house = {importer: source, "cartgrasp.cli": "", "cartgrasp.studies:package": "", "cartgrasp:package": ""}
    assert len(forbidden_arrows(imports(house))) == 1


@pytest.mark.parametrize(
    ("importer", "source"),
    [
        ("estimation.filter", "import cartgrasp as cg\nfrom cartgrasp.model import CartModel"),
        ("planning.limits.limit", "from ..plan import Plan\nimport numpy"),
        ("cartgrasp.cli", "import planning, estimation\nfrom .studies import table1"),
        ("cartgrasp.studies.table1", "import planning, estimation\nfrom .. import model"),
        ("cartgrasp.__main__", "from .cli import main"),
        ("cartgrasp.model", "from .planning import x\nimport planningless"),
    ],
)
def test_an_allowed_arrow_is_not(importer, source):
    house = {importer: source, "cartgrasp.cli": "", "cartgrasp.model": "", "planning.plan": ""}
    assert not forbidden_arrows(imports({**house, importer: source}))


def test_circles_are_found():
    house = {
        "cartgrasp.a": "from .b import f",
        "cartgrasp.b": "from . import c",
        "cartgrasp.c": "import cartgrasp.a",
        "cartgrasp.d": "from .a import f",
    }
    assert circles(imports(house), with_hidden=False) == [["cartgrasp.a", "cartgrasp.b", "cartgrasp.c"]]
    house["cartgrasp.c"] = "def f():\n    import cartgrasp.a"
    assert not circles(imports(house), with_hidden=False)
    assert circles(imports(house), with_hidden=True) == [["cartgrasp.a", "cartgrasp.b", "cartgrasp.c"]]


@pytest.mark.parametrize(
    "source",
    [
        *(
            "import pickle",
            "from pickle import loads",
            "import yaml",
            "from yaml import load",
            "import joblib",
        ),
        *("eval('1')", "def f(x):\n    exec(x)", "np.load(p, allow_pickle=True)", "YAML(typ='unsafe')"),
    ],
)
def test_unsafe_code_is_found(source):
    assert len(unsafe({"cartgrasp.a": source})) == 1


def test_safe_code_is_not():
    assert not unsafe({"cartgrasp.a": "from .yaml_file import read\nYAML(typ='rt').load(x)\nmodel.eval()\nnp.load(p)"})


def test_names_of_two_numbers_are_found():
    tree_of = {"a": "FAR = 2.0\nFEW, SURE = 3, 4.0", "b": "FAR = 6.0\nFEW = 3\nWORDS = ('a',)", "c": "WORDS = ('b',)"}
    assert ambiguous(tree_of) == {"FAR": ["a", "b"]}


def test_long_files_are_found():
    assert not too_long({"cartgrasp.a": "x = 1\n" * LONGEST})
    assert too_long({"cartgrasp.a": "x = 1\n" * (LONGEST + 1)})
