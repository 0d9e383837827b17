"""Writes the folder: our C, the problem's numbers, OSQP's generated sources and licence."""

from __future__ import annotations

import os
from importlib import metadata, resources
from pathlib import Path

import numpy as np
import osqp
from scipy import sparse

from cartgrasp.errors import UsageError
from cartgrasp.writing import write_folder

from .problem_code import EmbeddedProblem, header, source

MARKER_FILE = "problem.h"  # what a folder of ours holds
SYMBOL_PREFIX = "cartgrasp_osqp_"


def export_c(problem: EmbeddedProblem, folder: str | os.PathLike[str], wrench: tuple[float, float, float]) -> Path:
    """Written aside, then renamed; an earlier export is replaced, anything else is left alone. `wrench` is what
    `make check` plans."""
    folder = Path(folder)
    check_free(folder)
    return write_folder(folder, lambda aside: _fill(aside, problem, wrench))


def check_free(folder: Path) -> None:
    """Refuses a place that holds something else."""
    if folder.exists() and not folder.is_dir():
        raise UsageError(f"{folder}: is a file; name a folder")
    if folder.is_dir() and any(folder.iterdir()) and not (folder / MARKER_FILE).is_file():
        raise UsageError(f"{folder}: holds other files; name a new folder, or one that export-c wrote")


def _fill(folder: Path, problem: EmbeddedProblem, wrench: tuple[float, float, float]) -> None:
    _write_osqp(problem, folder / "osqp")
    for file in resources.files(__package__).joinpath("c").iterdir():
        (folder / file.name).write_bytes(file.read_bytes())
    texts = {
        "problem.h": header(problem),
        "problem.c": source(problem),
        "wrenches.txt": f"# fx fy (N) and moment (N m) on the cart\n{' '.join(map(repr, wrench))}\n",
    }
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="utf-8")


def _write_osqp(problem: EmbeddedProblem, folder: Path) -> None:
    """OSQP's solver with this problem's workspace. Its `matrices` mode lets contacts change without allocation."""
    program = problem.program
    solver = osqp.OSQP()
    solver.setup(
        P=sparse.csc_matrix(np.triu(program.hessian)),
        q=program.gradient.copy(),
        A=problem.matrix,
        l=program.lower.copy(),
        u=program.upper.copy(),
        verbose=False,
        polishing=False,
        check_termination=10,
        adaptive_rho_interval=50,
    )
    solver.codegen(str(folder), parameters="matrices", extension_name=None, prefix=SYMBOL_PREFIX)
    for name in ("CMakeLists.txt", "Makefile", "emosqp.c"):
        (folder / name).unlink(missing_ok=True)
    licence = next(file for file in metadata.files("osqp") or () if file.name == "LICENSE")
    (folder / "LICENSE").write_text(licence.read_text(), encoding="utf-8")
