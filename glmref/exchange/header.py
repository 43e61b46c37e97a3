"""The comment at the head of an exported file: what it is, whose it is, what wrote it."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from .. import __version__
from ..catalogue.claims import NYSTROM_ORDER, ORDER, ORDER_TO_DIGITS, SOLUTION
from ..method import GLM, AdditiveGLM, Method, PartitionedGLM
from ..views.tables import counted


@dataclass(frozen=True)
class Comment:
    """How a language writes a comment of several lines."""

    #: Lines before and after, "" where there are none.
    begin: str
    margin: str  #: What each line begins with.
    end: str

    def of(self, lines: Sequence[str]) -> str:
        """Write lines as a comment."""
        body = [f"{self.margin}{line}".rstrip() for line in lines]
        return "\n".join(
            [*([self.begin] if self.begin else []), *body, *([self.end] if self.end else [])]
        )


def in_comment(text: object) -> str:
    """Write any text on one line that ends no comment and continues none."""
    line = re.sub(r"\s+", " ", str(text)).strip()
    line = "".join(x for x in line if x.isprintable()).replace("\\", "/")  # which may end a pair
    for pair in ("*/", "/*", "#=", "=#", '"""'):
        line = line.replace(pair, " ".join(pair))
    return line


def _orders(claims: Mapping[str, Any], *, nystrom: bool) -> str:
    """Return what is claimed of the order, to begin the sentence on the size."""
    said = []
    if isinstance(claims.get(ORDER.key), int):
        said.append(str(claims[ORDER.key]))
    if isinstance(claims.get(NYSTROM_ORDER.key), int):
        said.append(f"{claims[NYSTROM_ORDER.key]} on second-order systems")
    if SOLUTION in claims.get(ORDER_TO_DIGITS.key, {}):
        order, size = claims[ORDER_TO_DIGITS.key][SOLUTION]
        on = " on second-order systems" if nystrom else ""
        said.append(f"{order}{on} but for residuals of {size} or less")
    return f"Order {', '.join(said)}, " if said else ""


#: Languages of steppers; the other targets are tables.
LANGUAGES = ("c", "c++", "fortran", "julia", "rust", "python", "jax")
#: Tables that hold all of a method, and those that hold its first embedded row.
COMPLETE, ONE_ROW = ("json", "csv"), ("sundials", "petsc", "diffrax", "ordinarydiffeq")


def left_out(method: Method, target: str) -> list[str]:
    """Return what a method has and its export to a target does not hold, in words.

    Parameters
    ----------
    method : Method
        A method that can be exported to the target.
    target : str
        One of :data:`glmref.exchange.export.TARGETS`.
    """
    if target in COMPLETE:
        return []
    names = [in_comment(row.name) for row in method.embedded]
    names = [] if target == "latex" else names[1:] if target in ONE_ROW else names
    found = [f"the embedded row {name}" for name in names]
    if getattr(method, "dense", None) is not None:
        found.append("the dense output")
    if target not in LANGUAGES:
        blocks = {"starting": "starting method", "finishing": "finishing method"}
        blocks |= {"output": "output of q", "output_hat": "output of p"}
        found += [f"the {x}" for key, x in blocks.items() if getattr(method, key, None) is not None]
    return found


def facts(method: GLM | PartitionedGLM | AdditiveGLM) -> list[str]:
    """Name, title, order, size and source of a method, one sentence each."""
    document = method.document or {}
    name, title = method.name or "a method without a name", document.get("title", "")
    lines = [in_comment(f"{name}: {title}" if title else name)]
    stages = [len(c.A) for c in method.carriers]
    values = [len(c.V) for c in method.carriers]
    orders = _orders(method.claims, nystrom=document.get("class") == "nystrom")
    if method.parts == 2:
        size = f"{counted(stages[0], 'stage')} Q, {counted(stages[1], 'stage')} P, "
        size += f"{counted(values[0], 'value')} of q and {values[1]} of p"
    else:
        size = f"{len(method.components)} parts, " if method.additive else ""
        size += f"{counted(stages[0], 'stage')}, {counted(values[0], 'value')}"
    lines.append(f"{orders}{size}.")
    if "citation" in method.source:
        where = method.source.get("where", "")
        lines.append(
            in_comment(f"Source: {method.source['citation']}" + (f" ({where})" if where else ""))
        )
    if "doi" in method.source:
        lines.append(in_comment(f"doi: {method.source['doi']}"))
    return lines


def header(
    method: GLM | PartitionedGLM | AdditiveGLM,
    target: str,
    comment: Comment,
    *remarks: str,
    exact: Sequence[str] = (),
) -> str:
    """Return the comment at the head of a file.

    Parameters
    ----------
    method : GLM or PartitionedGLM or AdditiveGLM
        The method that the file holds.
    target : str
        What it is exported to.
    comment : Comment
        How the language writes comments.
    remarks : str
        Further sentences, wrapped to 96 columns like the others.
    exact : Sequence[str]
        Lines that are not wrapped, with exact expressions of entries.
    """
    absent = left_out(method, target)
    lines = [*facts(method), *([f"Left out: {', '.join(absent)}."] if absent else []), *remarks]
    lines.append(f"Generated by glmref {__version__}.")
    width = 96 - len(comment.margin)
    body = [x for line in lines for x in textwrap.wrap(line, width)]
    return comment.of([*body, *exact])
