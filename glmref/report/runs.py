"""One page for each file of records: question and answer, pictures, and the records as a table."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from functools import cache
from typing import Any

from ..errors import GlmrefError
from ..views.tables import counted
from .markup import Column, Figure, Page, Site, Table, number, render
from .orbits import orbits
from .store import Record, RunFile, is_number, method_of, path_in

_ERRORS = ("state_error", "energy_error", "invariant_drift", "form_drift", "largest")
_COSTS = ("seconds", "evaluations", "steps", "h")
#: Runs of a picture in which each has a bar: more would cover it.
MOST_BARS = 100
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
    (Column("limit", "stable to h"), _at("limit")),
    (Column("lost", "lost at t"), _at("lost")),
    (Column("predicted", "predicted t"), _at("predicted")),
    (Column("largest", "largest rest"), _at("largest")),
    (Column("seconds", "seconds, median"), _at("seconds", "median")),
    (Column("q25", "first quartile"), _at("seconds", "q25")),
    (Column("q75", "third quartile"), _at("seconds", "q75")),
    (Column("evaluations", "evaluations"), _at("evaluations")),
    (Column("iterations", "iterations"), _at("iterations")),
    (Column("start", "evaluations of the start"), _at("start_evaluations")),
)  # fmt: skip


def tab_of(run: RunFile) -> str:
    """Return the name of the page of a run."""
    return f"run-{run.name}"


def run_page(site: Site, run: RunFile, methods: frozenset[str]) -> Page:
    """Write the page of one file of records; ``methods`` have a page of their own."""
    title, question, judged = about(run)
    shown = [(c, get) for c, get in COLUMNS if any(get(x) is not None for x in run.records)]
    if all(path_in(x, ("seconds", "repeats")) == 1 for x in run.records):
        shown = [(c, get) for c, get in shown if c.key not in ("q25", "q75")]  # the median again
    cells = [[number(get(record)) for _, get in shown] for record in run.records]
    caption = f"{counted(len(cells), 'record')} of {run.name}"
    table = Table(f"t-{run.name}", caption, [column for column, _ in shown], cells)
    keys = {column.key for column, _ in shown}
    # the error that the scene judges by comes first
    errors = sorted(
        (key for key in _ERRORS if key in keys), key=lambda key: key != f"{judged}_error"
    )
    costs = [key for key in _COSTS if key in keys]
    horizon = _horizon(run)
    far = f" Runs go {horizon}." if horizon else ""
    work = None
    if errors and costs:
        few = len(run.records) <= MOST_BARS and "q25" in keys
        bars = " Bars span the quartiles of the run times." if few else ""
        work = Figure(
            table.id, costs, errors, f"error against cost, {title}",
            f"Runs of one method are joined in the order of the file.{bars}{_failures(run)}{far}",
            bars=few,
        )  # fmt: skip
    used = dict.fromkeys(method_of(x) for x in run.records)
    curves, paths = _curves(run, title, far), orbits(run, title, far)
    drawn = [(work, table), *([curves] if curves else [])]
    drawn += [(paths.figure, paths.table)] if paths else []
    body = render(
        "run.html",
        question=question,
        quick=_is_quick(run),
        answer=answer_of(run),
        mixed=_mixed(run),
        curves=curves,
        work=work,
        table=table,
        unfinished=_unfinished(run.records),
        orbits=paths,
        horizon=horizon,
        methods=[site.link(f"method-{x}", x) if x in methods else x for x in used],
    )
    pictures = tuple(figure.lines_of(numbers) for figure, numbers in drawn if figure)
    return Page(tab_of(run), title, body, run.name, "scenes", _kind(run), pictures)


def about(run: RunFile) -> tuple[str, str, str]:
    """Return title, question and judged error: as the run wrote them, else of the shipped scene.

    A scene of the name of a shipped one may be a changed copy of it.
    """
    found = {key: str(run.about.get(key, "")) for key in ("title", "question", "judged")}
    scene = None if any(found.values()) else _shipped(run)
    if scene is not None:
        return scene.title, scene.question, scene.answer.error
    return found["title"] or run.name, found["question"], found["judged"]


def _failures(run: RunFile) -> str:
    """Say what crosses and dotted lines are, where the records have some."""
    if not any(is_number(x.get("limit")) for x in run.records):
        return ""
    return (
        " Against h, crosses at the top are runs that failed, and a dotted line is the step size "
        "up to which the tableau predicts stability along the solution."
    )


def _horizon(run: RunFile) -> str:
    """Return how far the runs were to go: a quick run ends earlier than its scene."""
    times = [path_in(x, ("task", "t_end")) for x in run.records]
    ends = sorted({number(t) for t in times if is_number(t)}, key=float)
    if not ends:
        return ""
    return f"to t = {ends[0]}" if len(ends) == 1 else f"to t = {ends[0]} up to {ends[-1]}"


def _kind(run: RunFile) -> str:
    """Return the heading of a scene in the menu."""
    from ..scenes import names

    if run.scene not in names():
        return "your own"
    return _KINDS.get(_scene(run.scene, _is_quick(run)).answer.kind, "others")


def answer_of(run: RunFile) -> str:
    """Return what the run wrote, else the answer of the records of a shipped scene, or ``""``."""
    from ..scenes import answer, names

    written = str(run.about.get("answer", ""))
    if written or run.scene not in names():
        return written
    if not run.records:
        return "no record yet"
    try:
        return answer(_scene(run.scene, _is_quick(run)), run.records)
    except (GlmrefError, KeyError, TypeError, ValueError, OverflowError) as error:
        return f"no answer: a record lacks something ({type(error).__name__}: {error})"


def _mixed(run: RunFile) -> list[str]:
    """Say that run times are of several kinds of machine, where they are and the scene is known."""
    from ..scenes import mixed_machines

    scene = _shipped(run)
    return mixed_machines(scene, run.records) if scene else []


def _is_quick(run: RunFile) -> bool:
    return run.name.endswith("-quick")


@cache
def _scene(name: str, quick: bool) -> Any:
    """Read a shipped scene once: its page and the overview both ask for it."""
    from ..scenes import load_scene

    return load_scene(name, quick=quick)


def _shipped(run: RunFile) -> Any:
    """Return the shipped scene that a run carried out, or nothing."""
    from ..scenes import names

    return _scene(run.scene, _is_quick(run)) if run.scene in names() else None


def _unfinished(records: Sequence[Record]) -> list[tuple[str, Any, str]]:
    """Name, step and reason of each run that was not completed."""
    return [
        (method_of(x), _step(x), _reason(x)) for x in records if x.get("outcome") != "completed"
    ]


def _reason(record: Record) -> str:
    """Return outcome and message of a run, or the message where it begins with the outcome."""
    outcome, message = str(record.get("outcome")), str(record.get("message") or "")
    return message if message.startswith(outcome) else ": ".join(filter(None, (outcome, message)))


def _curves(run: RunFile, title: str, far: str) -> tuple[Figure, Table] | None:
    """Draw what the records say over time, with the numbers."""
    cells, runs = [], Counter(method_of(x) for x in run.records)
    for record in run.records:
        series = record.get("series")
        name = method_of(record)
        if runs[name] > 1:
            name += f", h = {number(_step(record))}"
        for pair in series if isinstance(series, list) else ():
            if isinstance(pair, list) and len(pair) == 2:
                cells.append([name, number(pair[0]), number(pair[1])])
    if not cells:
        return None
    lost = any("lost" in x for x in run.records)
    what = "size of the values beyond the solution" if lost else "relative drift so far"
    columns = [Column("method", "method"), Column("t", "time t"), Column("value", what)]
    table = Table(f"c-{run.name}", f"{what}, largest up to each time", columns, cells)
    caption = f"{what[:1].upper()}{what[1:]}, the largest up to each time.{far}"
    label = f"{what} over time, {title}"
    return Figure(table.id, ["t"], ["value"], label, caption, marks=False), table
