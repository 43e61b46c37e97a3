"""What a notebook shows: a method as its tableau, a problem as formulas, a solution as a summary.

The HTML stands by itself: its few rules of style are in it, colours are those of the notebook, and
mathematics is MathML, which browsers show without a script.
"""

from __future__ import annotations

from functools import singledispatch
from typing import Any

from markupsafe import Markup

from ..engine.outcome import Solution
from ..errors import UsageError
from ..method import GLM, AdditiveGLM, PartitionedGLM
from ..problems.model import Problem
from ..prove.analysis import Analysis
from ..system.shown import ShownList
from ..views.facts import analysis_rows
from ..views.plot import plot
from ..views.problem_page import page
from ..views.show import parts
from .markup import render
from .typeset import typeset, typeset_table


@singledispatch
def html(record: object) -> str:
    """Return a record as HTML.

    Raises
    ------
    TypeError
        For a record that has none.
    """
    raise TypeError(f"{type(record).__name__} has no HTML")


def _shown(title: str, **parts_of: Any) -> str:
    empty = {"blocks": (), "legend": (), "rows": (), "picture": ""}
    return str(render("notebook.html", title=title, **{**empty, **parts_of}))


@html.register(GLM)
@html.register(PartitionedGLM)
@html.register(AdditiveGLM)
def _(record: GLM | PartitionedGLM | AdditiveGLM) -> str:
    drawn = parts(record, lambda grid: [typeset_table(grid)])  # type: ignore[arg-type,list-item]
    title, name = (record.document or {}).get("title", ""), record.name or "(unnamed)"
    return _shown(
        f"{name}: {title}" if title else name,
        blocks=drawn.blocks,
        legend=[(typeset(k), typeset(x)) for k, x in drawn.legend.items()],
    )


@html.register(Problem)
def _(record: Problem) -> str:
    return _shown(record.name, rows=page(record)[1:])


@html.register(Analysis)
def _(record: Analysis) -> str:
    title = record.method or "(unnamed)"
    return _shown(title, rows=analysis_rows(record.as_json()))


@html.register(ShownList)
def _(record: ShownList) -> str:
    """Return the findings, claim by claim."""
    named = ", ".join(dict.fromkeys(x.method for x in record if x.method))
    title = named or ("tableau" if record else "no claims")
    rows = [
        (x.claim, f"{x.verdict} ({x.proof})" + (f": {x.witness}" if x.witness else ""))
        for x in record
    ]
    return _shown(title, rows=rows)


@html.register(Solution)
def _(record: Solution) -> str:
    rows = [("outcome", str(record.outcome)), ("", record.message)]
    rows += [("steps", f"{record.steps} of h = {record.h:g}")]
    if len(record.t):
        rows.append(("time reached", f"{record.t[-1]:.10g}"))
        rows.append(("solution there", ", ".join(f"{x:.10g}" for x in record.y[-1])))
    rows += [
        ("rows kept", str(len(record.t))),
        ("evaluations", str(record.total_evaluations)),
        ("seconds", f"{record.seconds:.3g}, and {record.build_seconds:.3g} to make the kernel"),
        *(("notice", notice) for notice in record.notices),
    ]
    try:
        picture = Markup(plot(record))
    except UsageError:  # the end alone was kept
        picture = Markup()
    title = f"{record.problem} by {record.method}"
    return _shown(title, rows=[x for x in rows if x[1]], picture=picture)
