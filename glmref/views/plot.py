"""``plot(what)``: a method as its portrait, a solution against time."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np

from ..catalogue.lookup import method_of
from ..engine.outcome import Solution
from ..errors import UsageError
from ..method import GLM, AdditiveGLM, PartitionedGLM
from ..system.arguments import listed, one_of, whole
from ..system.shown import Drawing
from .axes import COLORS, Axes, document, round_ticks, text
from .chart import DASHES, place_labels
from .portrait import portrait

_MOST = 6  # components drawn where none are named
_POINTS = 2000  # of a line; more cannot be told apart


def plot(
    what: GLM | PartitionedGLM | AdditiveGLM | Solution | str | Path,
    *,
    components: Sequence[int] | None = None,
) -> Drawing:
    """Draw a method (stability region, eigenvalues, sparsity), or a solution against time.

    Parameters
    ----------
    what : GLM or PartitionedGLM or AdditiveGLM or Solution or str or Path
        A method, its name or its file, or a solution.
    components : Sequence[int] or None
        Of a solution: numbers from 0; the first six by default.

    Returns
    -------
    Drawing
        A picture in SVG: a notebook shows it, and ``save(path)`` writes it.

    Raises
    ------
    UsageError
        For anything else, and for a solution with fewer than two rows.
    """
    if not isinstance(what, Solution):
        return Drawing(portrait(method_of(what)))
    return plot_solution(what, "time", components)


def plot_solution(
    solution: Solution, kind: str, components: Sequence[int | str] | None = None
) -> Drawing:
    """See :meth:`.Solution.plot`."""
    one_of("kind", kind, KINDS)
    if len(solution.t) < 2:
        raise UsageError(
            "there is one point to draw; keep more of the run with solve(.., every=k) or times=.."
        )
    lines, labels = KINDS[kind](solution, components)
    title = f"{solution.problem}, {solution.method}, h = {solution.h:g}"
    return Drawing(_drawn(lines, labels, title, over_time=labels[0] == "t", equal=kind == "orbit"))


def _numbers(solution: Solution, components: Sequence[int | str]) -> list[int]:
    """Return numbers of components that are given by name or number."""
    d, names = solution.y.shape[1], solution.names
    what = "a list of names or numbers"
    chosen = [
        names.index(k) if isinstance(k, str) and k in names else whole("components", k, 0, d - 1)
        for k in listed("components", components, what)
    ]
    if not chosen:
        raise UsageError("`components` must name one at least")
    return chosen


def _thinned(solution: Solution) -> np.ndarray:
    return np.unique(np.linspace(0, len(solution.t) - 1, _POINTS).astype(int))


_Lines = tuple[dict[str, tuple[np.ndarray, np.ndarray]], tuple[str, str]]


def _time(solution: Solution, components: Sequence[int | str] | None) -> _Lines:
    """Return the components against time."""
    kept, names = _thinned(solution), _names(solution)
    times, rows = np.asarray(solution.t, dtype=float), np.asarray(solution.y, dtype=float)
    given = range(min(rows.shape[1], _MOST)) if components is None else components
    return {names[k]: (times[kept], rows[kept, k]) for k in _numbers(solution, given)}, ("t", "")


def _energy(solution: Solution, components: Sequence[int | str] | None) -> _Lines:
    """Return the relative error of the Hamiltonian; absolute where the energy at the start is 0."""
    problem = None if solution.origin is None else solution.origin[0]
    if problem is None or problem.conserved is None:
        raise UsageError("the energy is drawn of a solution whose problem gives its Hamiltonian")
    kept = _thinned(solution)
    energy = np.array([float(problem.conserved(y)) for y in solution.y[kept]])
    first = float(problem.conserved(np.asarray(problem.y0)))
    label = "(H - H(0)) / |H(0)|" if first else "H - H(0)"
    error = (energy - first) / (abs(first) or 1.0)
    return {"energy": (np.asarray(solution.t, dtype=float)[kept], error)}, ("t", label)


def _phase(solution: Solution, components: Sequence[int | str] | None) -> _Lines:
    """Return every p over its q."""
    d = solution.y.shape[1]
    problem = None if solution.origin is None else solution.origin[0]
    paired = d % 2 == 0 and (
        problem is None or problem.canonical or problem.separable or bool(problem.names)
    )
    if not paired:
        raise UsageError("the phase plane is drawn of states (q, p); name two `components` of an "
                         "orbit")  # fmt: skip
    half, kept, names = d // 2, _thinned(solution), _names(solution)
    given = range(min(half, _MOST)) if components is None else _numbers(solution, components)
    rows = np.asarray(solution.y, dtype=float)[kept]
    pairs = [k % half for k in given]
    lines = {f"{names[k]}, {names[half + k]}": (rows[:, k], rows[:, half + k]) for k in pairs}
    one = len(pairs) == 1
    return lines, (names[pairs[0]] if one else "q", names[half + pairs[0]] if one else "p")


def _orbit(solution: Solution, components: Sequence[int | str] | None) -> _Lines:
    """Return paths of bodies in the plane of their first two coordinates, or of two components."""
    kept, names = _thinned(solution), _names(solution)
    rows = np.asarray(solution.y, dtype=float)[kept]
    if components is not None:
        chosen = _numbers(solution, components)
        if len(chosen) != 2:
            raise UsageError(f"`components` of an orbit must be two, got {len(chosen)}")
        a, b = chosen
        return {f"{names[a]}, {names[b]}": (rows[:, a], rows[:, b])}, (names[a], names[b])
    half = rows.shape[1] // 2
    problem = None if solution.origin is None else solution.origin[0]
    bodies = getattr(problem, "bodies", 1)
    each = half // bodies
    if rows.shape[1] % 2 or each < 2:
        raise UsageError("an orbit needs two coordinates; name two `components`")
    lines = {
        f"{names[a]}, {names[a + 1]}": (rows[:, a], rows[:, a + 1]) for a in range(0, half, each)
    }
    return lines, (names[0], names[1])


def _names(solution: Solution) -> tuple[str, ...]:
    return solution.names or tuple(f"y[{k}]" for k in range(solution.y.shape[1]))


#: What :meth:`.Solution.plot` draws.
KINDS: Mapping[str, Callable[[Solution, Sequence[int | str] | None], _Lines]] = {
    "time": _time,
    "energy": _energy,
    "phase": _phase,
    "orbit": _orbit,
}


def _drawn(
    lines: Mapping[str, tuple[np.ndarray, np.ndarray]], labels: tuple[str, str], title: str, *,
    over_time: bool, equal: bool,
) -> str:  # fmt: skip
    """Return lines over linear axes, each named at its end where there are several.

    Those over time fill the width, and those that are ``equal`` have one unit on both axes.
    """
    across, up = (np.concatenate([line[k] for line in lines.values()]) for k in (0, 1))
    x, y = _range(across, 0.0 if over_time else 0.04), _range(up, 0.04)
    high = 400 if equal else 272
    if equal:
        unit = max((x[1] - x[0]) / 570, (y[1] - y[0]) / high)
        x, y = _about(x, unit * 570), _about(y, unit * high)
    axes = Axes(70, 44, 570, high, x, y)
    parts = axes.frame(round_ticks(*axes.x, most=8), round_ticks(*axes.y), labels, aside=56)
    ends = [v[np.isfinite(u) & np.isfinite(v)][-1:].sum() for u, v in lines.values()]
    wanted = [axes.at(axes.x[1], float(end))[1] for end in ends]
    places = place_labels(wanted, axes.top + 6, axes.bottom)
    for k, ((name, line), place) in enumerate(zip(lines.items(), places, strict=True)):
        color, dash = COLORS[k % len(COLORS)], DASHES[k % len(DASHES)]
        points = axes.line((a, b) for a, b in zip(*line, strict=True) if np.isfinite(a + b))
        parts.append(
            f'<polyline points="{points}" fill="none" stroke="{color}" stroke-width="1.5" '
            f'stroke-dasharray="{dash}"/>'
        )
        parts.append(text(axes.right + 8, place + 4, name, fill=color))
    return document(title, 720, high + 88, parts)


def _range(values: np.ndarray, margin: float) -> tuple[float, float]:
    """Return limits that hold the finite ones of some values, with a part of them as a margin."""
    finite = values[np.isfinite(values)]
    low, high = (float(finite.min()), float(finite.max())) if finite.size else (0.0, 1.0)
    more = margin * (high - low)
    if high == low:
        more = 0.5 * max(abs(high), 1.0)
    return low - more, high + more


def _about(limits: tuple[float, float], size: float) -> tuple[float, float]:
    """Return limits of a size around the same middle."""
    middle = (limits[0] + limits[1]) / 2
    return middle - size / 2, middle + size / 2
