"""The pictures of the documentation, drawn from records.

    python -m campaigns.pictures
    python -m campaigns.pictures growth data/measurements/parasitic-growth.json

The first form writes docs/images/*.svg; the second first measures what the picture of parasitic
growth shows: the part of the values along the eigenvector of V of eigenvalue -1, in a run of the
pendulum from 2.3 radians, and what :func:`glmref.predict` says of it at the start.
"""

import math
import re
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from campaigns.driver import arguments, complete, record_of, three_digits
from campaigns.gallery import TOLERANCES, costs
from campaigns.pages import measured
from campaigns.partitioned import strong
from campaigns.partitioned.work import mean
from glmref.catalogue.audits import audited_codes
from glmref.catalogue.lookup import document, load
from glmref.compute.records import lines_of
from glmref.engine.solve import solve
from glmref.measure.prediction import predict
from glmref.problems import problem
from glmref.system.shown import Drawing
from glmref.views.axes import COLORS, text
from glmref.views.axes import document as picture
from glmref.views.chart import NARROW, Series, svg

ROOT = Path(__file__).parents[1]
IMAGES = ROOT / "docs" / "images"
#: Method whose parasitic growth is shown, its step sizes, and samples of a run.
GROWING, STEPS, SAMPLES = "gsymplectic-n", (0.2, 0.1), 48
#: Order of the difference that takes the smooth part out of the second value.
DIFFERENCE = 8
#: What the picture of the audit shows: code and table, the wrong file and the right one, and the
#: part of the additive method that has the entry.
AUDITED, WRONG, RIGHT, PART = ("petsc", "TSARKIMEXBPR3"), "bpr-3-5-3-petsc", "bpr-3-5-3", 0
#: Methods of the headline, on second-order systems.
SHOWN = (
    "multistep-rkn-8", "multistep-rkn-12", "multivalue-rkn-12", "quinlan-tremaine-12",
    "dormand-prince-rkn-12-10", "kahan-li-8", "blanes-moan-rkn-6-14", "pair-rkn-6-8b",
)  # fmt: skip
#: Methods on systems that are not separable.
UNSEPARATED = (
    "multistep-strong-8", "multistep-strong-8b", "multistep-general-8b",
    "gauss-3", "gauss-4", "gauss-5", "gauss-6", "scipy-dop853",
)  # fmt: skip


def work() -> str:
    """Draw what 6, 9 and 12 digits cost: geometric means over second-order problems."""
    lines = []
    found = {t: list(costs("second order", t)) for t in TOLERANCES}
    every = [k for k, case in enumerate(found["1e-12"]) if set(SHOWN) <= case.keys()]
    for name in SHOWN:
        points = [(mean([cases[k][name] for k in every]), float(t)) for t, cases in found.items()]
        lines.append(Series(name, tuple(points)))
    title = f"Digits on {len(every)} second-order problems"
    return _chart(lines, title, "evaluations, geometric mean", "error at the end")


def nonseparable() -> str:
    """Draw what 6 and 9 digits cost on systems that are not separable, in geometric means."""
    counts = [
        {**strong.rivals(name, t), **{m: x["evaluations"][f"{t:g}"] for m, x in own.items()}}
        for name, own in strong.by_problem().items()
        for t in strong.TOLERANCES
        if strong.rivals(name, t)
    ]
    lines = []
    for name in UNSEPARATED:
        means = [mean([x[name] for x in counts[k::2]]) for k in range(2)]
        points = zip(means, strong.TOLERANCES, strict=True)
        lines.append(Series(name, tuple(points)))
    title = f"Digits on {len(counts) // 2} systems that are not separable"
    return _chart(lines, title, "evaluations, geometric mean", "error at the end")


def kepler() -> str:
    """Draw the records of the scene work-precision: error of the state against run time."""
    points: dict[str, list[tuple[float, float]]] = {}
    for _, record, _ in lines_of(IMAGES / "work-precision.jsonl"):
        if record is not None and record["outcome"] == "completed":
            at = record["seconds"]["median"], record["state_error"]
            points.setdefault(record["task"]["method"], []).append(at)
    lines = [Series(name, tuple(x)) for name, x in points.items()]
    return _chart(lines, "Kepler, eccentricity 0.6, ten periods", "seconds", "relative error")


def front() -> str:
    """Draw error constants against periodicity interval of the symmetric multistep methods."""
    record = measured("error-front")
    lines = []
    for pairs in (3, 4, 5):
        rows = [x for x in record["descents"] if x["pairs"] == pairs and x["apart"] == 0]
        found = tuple(sorted((x["end"], x["constant"]) for x in rows))
        lines.append(Series(f"least found, order {2 * pairs + 2}", found))
    methods = sorted(record["methods"], key=lambda x: x["method"])
    lines += [Series(x["method"], ((x["end"], x["constant"]),)) for x in methods]
    return _chart(lines, "Symmetric multistep methods", "periodicity interval", "error constant")


def energy() -> str:
    """Draw the energy error of the pendulum over a hundred million steps, against time."""
    lines = []
    for run in measured("pendulum-1e8")["runs"]:
        points = tuple((x["t"], x["largest"]) for x in run["doublings"])
        lines.append(Series(f"{run['method']}, h = {run['h']:g}", points))
    return _chart(lines, "Pendulum, 100 million steps", "time", "largest energy error")


def growth() -> str:
    """Draw parasitic growth, predicted at the start and seen in the run."""
    lines = []
    for run in measured("parasitic-growth")["runs"]:
        seen = tuple(zip(run["t"], run["size"], strict=True))
        predicted = tuple((t, run["start"] * math.exp(run["rate"] * t)) for t in run["t"])
        lines += [
            Series(f"h = {run['h']:g}, seen", seen),
            Series(f"h = {run['h']:g}, predicted", predicted),
        ]
    return _chart(lines, f"Parasitic part of {GROWING}, pendulum", "time", "size")


def _chart(lines: list[Series], title: str, across: str, up: str) -> str:
    return svg(lines, title=title, x_label=across, y_label=up, narrow=True, height=400)


def audited() -> str:
    """Draw a table as a code has it, with the entry marked that the audit names."""
    code, name = AUDITED
    table = next(x for x in audited_codes()[code]["tables"] if x["name"] == name)
    (said,) = table["correction"]
    rows, right = (document(x)["parts"][PART] for x in (WRONG, RIGHT))
    bad = [
        (i, j)
        for i, (one, other) in enumerate(zip(rows["A"], right["A"], strict=True))
        for j, (x, y) in enumerate(zip(one, other, strict=True))
        if x != y
    ]
    ((i, j),) = bad
    at = f"a[{i + 1}][{j + 1}]", rows["A"][i][j], right["A"][i][j]
    if at != (said["entry"], said["is"], said["should be"]):
        raise ValueError(f"the audit says {said}, the files differ at {at}")
    wide, high, left, top = 58, 34, 70, 62
    parts = []
    for m, row in enumerate([*rows["A"], rows["b"]]):
        y = top + high * m + (8 if m == len(rows["A"]) else 0)
        parts.append(text(left - 26, y, f"{m + 1}" if m < len(rows["A"]) else "b", "end", size=14))
        for n, entry in enumerate(row):
            wrong = (m, n) == (i, j)
            if wrong:
                parts.append(
                    f'<rect x="{left + wide * n - 24}" y="{y - 20}" width="48" height="28" rx="5" '
                    f'fill="none" stroke="{COLORS[1]}" stroke-width="2.5"/>'
                )
            fill = COLORS[1] if wrong else "#111"
            parts.append(text(left + wide * n, y, entry, "middle", size=15, fill=fill))
    line = top + high * len(rows["A"]) - 16
    parts.append(f'<path d="M{left - 40} {line}h{wide * 5 + 20}" stroke="#555"/>')
    parts.append(f'<path d="M{left - 20} {top - 22}v{high * 6 + 4}" stroke="#555"/>')
    verdict = f"{said['entry']} is {said['is']} and should be {said['should be']};"
    order = f"order {table['declared']} is declared, order {table['found']} found"
    below = line + high + 34
    parts += [text(12, below, verdict, size=14), text(12, below + 20, order, size=14)]
    return picture(f"{code}: {name}, explicit part", NARROW, below + 34, parts, 12)


def house() -> str:
    """Draw the subpackages from the ground up: each imports from below and from its left."""
    contributing = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    found = re.search(r"^## Layers\n.*?^```text\n(.*?)^```", contributing, re.M | re.S)
    rows = [line.split() for line in found[1].splitlines()] if found else []
    high, top, parts = 34, 44, []
    for k, row in enumerate(reversed(rows)):
        wide = (NARROW - 24) / len(row)
        for n, name in enumerate(row):
            x, y = 12 + wide * n, top + high * k
            parts.append(
                f'<rect x="{x + 2:.1f}" y="{y}" width="{wide - 4:.1f}" height="{high - 5}" rx="4" '
                f'fill="#eef3f8" stroke="{COLORS[0]}"/>'
            )
            parts.append(text(x + wide / 2, y + 20, name, "middle", size=14))
    below = top + high * len(rows) + 18
    said = "each imports from below and from its left"
    return picture("The house of glmref", NARROW, below + 12, [*parts, text(12, below, said)], 12)


#: Name of a picture -> what draws it.
PICTURES: Mapping[str, Callable[[], str]] = {
    "work": work, "nonseparable": nonseparable, "kepler": kepler, "error-front": front,
    "energy": energy, "parasitic-growth": growth, "audited": audited, "house": house,
}  # fmt: skip


def grown(h: float, part: float = 1.0) -> dict[str, Any]:
    """Return the parasitic part along a run with the step h, and what is predicted of it.

    The run takes this part of the way to the predicted loss.
    """
    method, target = load(GROWING), problem("pendulum", q0="23/10")
    (found,) = predict(method, target, h, 1e4).parts
    run = solve(target, method, h=h, steps=round(part * float(found.steps)), every=1, history=True)
    # it changes its sign in every step: of a difference of order k nothing but 2^k of it is left
    second = np.asarray(run.history)[:, 1]
    size = np.linalg.norm(np.diff(second, DIFFERENCE, axis=0), axis=1) / 2**DIFFERENCE
    at = range(0, len(size), max(1, round(float(found.steps) / SAMPLES)))
    return {
        "method": GROWING, "variant": f"h = {h:g}", "problem": target.name, "h": h, "zeta": -1,
        "start": three_digits(found.start), "rate": three_digits(float(found.rate)),
        "t": [round(float(run.t[k + DIFFERENCE // 2]), 6) for k in at],
        "size": [three_digits(float(size[k])) for k in at],
    }  # fmt: skip


def main() -> None:
    """Write all pictures."""
    for name, draw in PICTURES.items():
        Drawing(draw()).save(IMAGES / f"{name}.svg")


if __name__ == "__main__":
    *what, _ = words = [*arguments(sys.argv[1:]), ""]
    if what:
        title = "Parasitic growth on the pendulum, predicted and seen"
        note = (
            f"size: norm of the difference of order {DIFFERENCE} of the second value over "
            f"2^{DIFFERENCE}; start and rate: predicted, start exp(rate t)."
        )
        runs = list(map(grown, STEPS))
        record = record_of("pictures growth", "parasitic-growth", title, note, runs=runs)
        complete(Path(words[1]), record)
    main()
