"""One page for each file of records: question and answer, pictures, and the records as a table."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from functools import cache
from typing import Any

from ..errors import GlmrefError
from .markup import Column, Page, Site, Table, counted, escape, figure, number
from .orbits import orbits
from .store import Record, RunFile, method_of, path_in

__all__ = ["COLUMNS", "answer_of", "run_page", "tab_of"]

_ERRORS = ("state_error", "energy_error", "invariant_drift", "form_drift", "largest")
_COSTS = ("seconds", "evaluations", "steps", "h")
#: Scenes in the menu by what they answer.
_KINDS = {
    "fastest": "error against run time", "accurate": "error against evaluations",
    "conserved": "what is kept", "law": "laws of growth", "lost": "when methods are lost",
    "ended": "how runs end", "order": "orders",
}  # fmt: skip
_INVARIANTS = ("quadratic", "invariant", "hamiltonian")


def _step(record: Record) -> Any:
    task = record["task"]
    if "h" in task:
        return task["h"]
    return f"tol {task['tolerance']:g}" if isinstance(task.get("tolerance"), float) else None


def _drift(kinds: Sequence[str]) -> Callable[[Record], Any]:
    def largest(record: Record) -> Any:
        drifts = record.get("drifts")
        values = [
            x.get("largest")
            for x in (drifts if isinstance(drifts, list) else ())
            if isinstance(x, dict) and x.get("kind") in kinds
        ]
        numbers = [x for x in values if isinstance(x, int | float)]
        # NaN among them is shown, and not hidden by the others
        return max(numbers, key=lambda x: (x != x, x), default=None)

    return largest


def _at(*keys: str) -> Callable[[Record], Any]:
    return lambda record: path_in(record, keys)


#: Columns of a run's table, and where in a record each number is.
COLUMNS: tuple[tuple[Column, Callable[[Record], Any]], ...] = (
    (Column("method", "method"), method_of),
    (Column("h", "step size h"), _step),
    (Column("steps", "steps"), _at("steps")),
    (Column("outcome", "outcome"), _at("outcome")),
    (Column("state_error", "error of the state, relative"), _at("state_error")),
    (Column("energy_error", "error of the energy, relative"), _at("energy_error")),
    (Column("invariant_drift", "drift of invariants"), _drift(_INVARIANTS)),
    (Column("form_drift", "drift of the form G"), _drift(("form",))),
    (Column("lost", "lost at t"), _at("lost")),
    (Column("predicted", "mu f' says t"), _at("predicted")),
    (Column("largest", "largest rest"), _at("largest")),
    (Column("seconds", "seconds, median"), _at("seconds", "median")),
    (Column("q25", "first quartile"), _at("seconds", "q25")),
    (Column("q75", "third quartile"), _at("seconds", "q75")),
    (Column("evaluations", "evaluations"), _at("evaluations")),
    (Column("iterations", "iterations"), _at("iterations")),
    (Column("start", "evaluations of the start"), _at("start_evaluations")),
)  # fmt: skip


def tab_of(run: RunFile) -> str:
    """Name of the page of a run."""
    return f"run-{run.name}"


def run_page(site: Site, run: RunFile, methods: frozenset[str]) -> Page:
    """Page of one file of records.

    Args:
        methods: names that have a page of their own.
    """
    title, parts, judged = _question(run)
    intro = len(parts)
    shown = [(c, get) for c, get in COLUMNS if any(get(x) is not None for x in run.records)]
    cells = [[number(get(record)) for _, get in shown] for record in run.records]
    caption = f"{counted(len(cells), 'record')} of {run.name}"
    table = Table(f"t-{run.name}", caption, [column for column, _ in shown], cells)
    keys = {column.key for column, _ in shown}
    # the error that the scene judges by comes first
    errors = sorted((key for key in _ERRORS if key in keys), key=lambda key: key != judged)
    costs = [key for key in _COSTS if key in keys]
    if errors and costs:
        parts.append(
            figure(
                table.id, costs, errors, f"error against cost, {title}",
                "Runs of one method are joined in the order of the file. Bars span the quartiles "
                "of the run times.",
            )
        )  # fmt: skip
    parts.append(table.html())
    parts += _unfinished(run.records)
    curves = _curves(run, title)
    # where a run is watched over time, that picture is the answer
    parts = [*parts[:intro], *curves, *parts[intro:]]
    parts += orbits(run, title)
    parts.append(_methods(site, run, methods))
    return Page(tab_of(run), title, "\n".join(parts), run.name, "scenes", _kind(run))


def _kind(run: RunFile) -> str:
    """Heading of a scene in the menu."""
    from ..scenes import names

    if run.scene not in names():
        return "your own"
    return _KINDS.get(_scene(run.scene, _is_quick(run)).answer.kind, "others")


def answer_of(run: RunFile) -> str:
    """The answer that the records of a shipped scene give; ``""`` for another scene."""
    from ..scenes import answer, names

    if run.scene not in names():
        return ""
    if not run.records:
        return "no record yet"
    try:
        return answer(_scene(run.scene, _is_quick(run)), run.records)
    except (GlmrefError, KeyError, TypeError, ValueError, OverflowError) as error:
        return f"no answer: a record lacks something ({type(error).__name__}: {error})"


def _is_quick(run: RunFile) -> bool:
    return run.name.endswith("-quick")


@cache
def _scene(name: str, quick: bool) -> Any:
    """Read a shipped scene once: its page and the overview both ask for it."""
    from ..scenes import load_scene

    return load_scene(name, quick=quick)


def _question(run: RunFile) -> tuple[str, list[str], str]:
    """Title, question and answer of a shipped scene, and the error it judges by."""
    from ..scenes import names

    parts = []
    if _is_quick(run):
        parts.append("<p>A quick run: fewer or shorter runs than the scene asks for.</p>")
    if run.scene not in names():
        return run.name, [*parts, "<p>A scene of the user's own: its records are shown.</p>"], ""
    scene = _scene(run.scene, _is_quick(run))
    said = answer_of(run)
    parts.insert(0, f"<p><strong>{escape(scene.question)}</strong></p>")
    parts.append(f'<p class="answer">{escape(said)}</p>')
    return scene.title, parts, f"{scene.answer.error}_error"


def _unfinished(records: Sequence[Record]) -> list[str]:
    """Say of each run that was not completed why."""
    rows = [
        f"<li><strong>{escape(method_of(x))}</strong>, {number(_step(x))}: "
        f"{escape(': '.join(filter(None, (str(x.get('outcome')), str(x.get('message') or '')))))}"
        for x in records
        if x.get("outcome") != "completed"
    ]
    return [f"<h2>Not completed: {len(rows)}</h2><ul>{''.join(rows)}</ul>"] if rows else []


def _curves(run: RunFile, title: str) -> list[str]:
    """Picture and numbers of what the records say over time."""
    cells, runs = [], Counter(method_of(x) for x in run.records)
    for record in run.records:
        series = record.get("series")
        name = method_of(record)
        if runs[name] > 1:
            name += f", h = {number(_step(record))}"
        for pair in series if isinstance(series, list) else ():
            if isinstance(pair, list) and len(pair) == 2:
                cells.append([escape(name), number(pair[0]), number(pair[1])])
    if not cells:
        return []
    lost = any("lost" in x for x in run.records)
    what = "size of the values beyond the solution" if lost else "relative drift so far"
    columns = [Column("method", "method"), Column("t", "time t"), Column("value", what)]
    table = Table(f"c-{run.name}", f"{what}, largest up to each time", columns, cells)
    caption = f"{what[:1].upper()}{what[1:]}, the largest up to each time."
    label = f"{what} over time, {title}"
    picture = figure(table.id, ["t"], ["value"], label, caption, marks=False)
    return [
        "<h2>Over time</h2>",
        picture,
        f"<details><summary>The numbers of this picture</summary>{table.frame()}</details>",
    ]


def _methods(site: Site, run: RunFile, methods: frozenset[str]) -> str:
    names = dict.fromkeys(method_of(x) for x in run.records)
    links = ", ".join(site.link(f"method-{x}", x) if x in methods else escape(x) for x in names)
    return f"<h2>Methods</h2><p>{links}</p>" if names else ""
