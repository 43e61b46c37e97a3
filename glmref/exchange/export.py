"""``export(method, to=...)``: a method as the source file or the table of somebody else."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..catalogue.canonical import canonical
from ..catalogue.lookup import method_of
from ..catalogue.reader import load_document
from ..errors import UsageError
from ..method import GLM, AdditiveGLM, PartitionedGLM
from ..system.arguments import no_such, place
from ..system.files import write_text
from .cells import to_cells
from .documents import blocks_of, method_document
from .header import COMPLETE, LANGUAGES
from .numbers import check_digits
from .steppers import stepper
from .tables import table

#: What a method can be exported to: steppers, then tables, and a method file, also in cells.
TARGETS = (
    *LANGUAGES,
    *("latex", "sundials", "petsc", "diffrax", "ordinarydiffeq", "rungekutta.jl", "json", "csv"),
)
#: Other usual names of targets; capitals do not matter.
ALIASES = {"cpp": "c++", "cxx": "c++", "f90": "fortran"}


def export(
    method: GLM | PartitionedGLM | AdditiveGLM | str | Path, *, to: str, digits: int | None = None
) -> str:
    """Return a method as a source file or as a table of another package.

    Parameters
    ----------
    method : GLM or PartitionedGLM or AdditiveGLM or str or Path
        A method, its name, or the path of its file.
    to : str
        One of :data:`TARGETS`, in capitals or not, or of :data:`ALIASES`. The languages give a
        stepper without dependencies, with start and finish; pairs are stepped on separable systems
        q' = dq(p), p' = dp(q).
    digits : int or None
        Significant digits of decimals (in JSON and CSV digits after the point). By default steppers
        have the shortest decimals that give the nearest doubles, tables 34 digits where a number is
        no quotient, LaTeX exact expressions, and JSON and CSV are the method file.

    Raises
    ------
    UsageError
        For an unknown target, and for a method that the target cannot hold.
    DataError
        For a file that is not what it must be.
    """
    if isinstance(to, str):
        to = ALIASES.get(to.lower(), to.lower())
    if not isinstance(to, str) or to not in TARGETS:
        raise no_such("target of an export", to, TARGETS)
    check_digits(digits)
    method = method_of(method)
    if to in COMPLETE:
        found = _document(method, method.name or "method", digits)
        return canonical(found) if to == "json" else to_cells(found)
    if method.rosenbrock:
        raise UsageError(
            f"{method.name} is a Rosenbrock method: json and csv hold it, and {to} does not"
        )
    if isinstance(method, AdditiveGLM):
        if to in ("petsc", "sundials", "latex"):
            return table(method, to, digits)
        raise UsageError(
            f"{method.name} is additive: petsc, sundials, json, csv and latex hold its tableaux, "
            f"and {to} single methods and pairs; export its parts, "
            f"glmref.export(method.part(1), to={to!r})"
        )
    if to in LANGUAGES:
        return stepper(method, to, digits)
    return table(method, to, digits)


def save(
    method: GLM | PartitionedGLM | AdditiveGLM, path: str | Path, *, digits: int | None = None
) -> Path:
    """Write a method as a method file: what it came from, or its blocks, claims and source.

    See :meth:`.Method.save`; a file that is there is replaced.

    Raises
    ------
    UsageError
        For a file that cannot be written, or a method that no file can hold.
    """
    method = method_of(method)
    file = place("path", path)
    check_digits(digits)
    write_text(file, canonical(_document(method, file.name, digits)))
    return file


def _document(
    method: GLM | PartitionedGLM | AdditiveGLM, name: str, digits: int | None
) -> dict[str, Any]:
    """Return the document of a method file: see :func:`save`."""
    document = dict(method.document or {})
    if digits is not None or not _is_of(document, method):
        document = method_document(method, name, digits)
        if method.claims:
            here = {"citation": "saved by glmref", "where": name, "status": "derived"}
            document |= {"claims": dict(method.claims), "source": dict(method.source or here)}
    return document


def _is_of(document: Mapping[str, Any], method: GLM | PartitionedGLM | AdditiveGLM) -> bool:
    """Return whether a method is what its file says: `dataclasses.replace` keeps the document."""
    if not document or document.get("name") != method.name:
        return False
    read = load_document(document)
    return type(read) is type(method) and blocks_of(read, None) == blocks_of(method, None)
