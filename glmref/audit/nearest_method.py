"""Methods to compare a table with: those of the catalogue."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ..catalogue.claims import meant_order
from ..catalogue.lookup import document, load, names
from ..errors import GlmrefError
from ..exact.expression import shown_number
from .table import Table

#: Entries nearer than this are the same, printed shorter.
NEAR = 1e-9
#: Steps of a flow that say of which splitting they are: fewer stand in several.
STEPS = 3
#: Classes with methods of one value whose stages are those of a Runge-Kutta method, and splittings.
CLASSES = frozenset({"composition", "lmm", "one-leg", "rk", "splitting"})
#: A table is compared with a method that agrees in at least this part of its nonzero entries.
ALIKE = 0.6


class Library:
    """Runge-Kutta methods of the catalogue by their number of stages, and its splittings."""

    def __init__(self) -> None:
        #: Name, a and b of each splitting, and its order on second-order systems.
        self.splittings: list[tuple[str, list[complex], list[complex], int]] = []
        self.methods: dict[int, list[tuple[str, int, Any, list[list[complex]]]]] = {}
        for name in names():
            given = document(name)
            if given["class"] not in CLASSES:
                continue
            try:
                method = load(name)
            except GlmrefError:  # a file beyond what is read here
                continue
            if given["class"] == "splitting":
                a, b = ([complex(x) for x in x.B[0]] for x in method.components)
                self.splittings.append((name, a, b, meant_order(given["claims"]) or 0))
            c = method.components[0]
            if len(method.components) == len(c.V) == 1 and c.V[0][0] == 1:
                rows = [*c.A, c.B[0]]
                claimed = int(given["claims"].get("order", 99))
                values = [[complex(x) for x in row] for row in rows]
                self.methods.setdefault(len(c.A), []).append((name, claimed, rows, values))

    def steps(self, table: Table, order: int) -> str:
        """Say which splitting of an order has the steps of one flow, and those of the other."""
        found = [[complex(x.value) for x in row] for row in table.b]
        for name, a, b, reached in self.splittings:
            for k, (word, right, other) in enumerate((("a", a, b), ("b", b, a))):
                same = found[k]
                alike = STEPS <= len(same) == len(right) and all(
                    abs(x - y) < NEAR for x, y in zip(same, right, strict=True)
                )
                if alike and reached >= order and len(found[1 - k]) != len(other):
                    shown = ", ".join(f"{x.real:.12g}" for x in other)
                    return f"{word} is that of {name}, which has {len(other)} {'ba'[k]}: {shown}"
        return ""

    def nearest(self, table: Table, order: int = 0) -> dict[str, Any]:
        """Return the name of the nearest method of an order and the entries that differ, if any."""
        best: tuple[int, str, list[dict[str, str]], int] | None = None
        for name, entries, reached in self._compared(table, order):
            if best is None or len(entries) < best[0]:
                best = (len(entries), name, entries, reached)
        if best is None:
            return {}
        found = {"method": best[1], "entries": best[2][:12], "differing": best[0]}
        return found | ({"order": best[3]} if table.general and best[3] < 99 else {})

    def _compared(
        self, table: Table, order: int
    ) -> Iterator[tuple[str, list[dict[str, str]], int]]:
        for part, (A, b) in enumerate(zip(table.A, table.b, strict=True)):
            rows = [[complex(x.value) for x in row] for row in (*A, b)]
            count = sum(x != 0 for row in rows for x in row)
            for name, reached, right, values in self.methods.get(len(b), []):
                if reached < order:
                    continue
                unlike = [
                    (i, j)
                    for i, (x, y) in enumerate(zip(rows, values, strict=True))
                    for j in range(len(b))
                    if abs(x[j] - y[j]) > NEAR
                ]
                if len(unlike) <= (1 - ALIKE) * count:
                    yield (
                        name,
                        [
                            {
                                "entry": (f"a[{i + 1}][{j + 1}]" if i < len(b) else f"b[{j + 1}]")
                                + (" of part 2" if part else ""),
                                "is": f"{rows[i][j].real:.17g}",
                                "there": shown_number(right[i][j]),
                            }
                            for i, j in unlike
                        ],
                        reached,
                    )
