"""Pairs of bodies, and a loop that vectors fit: ``python -m tools.measure.compare_bodies``.

``tools/measure/c/bodies.c`` has the force of N bodies twice: every pair once, as the engine has
it, and with the pulled body inside, which computes every pair twice and is packed into vectors.
Both have the same bits. Microseconds of processor time for one evaluation, least of interleaved
repetitions, at ``-O3`` with vectors as wide as the processor has.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import numpy as np

from tools.measure.compare_c import built
from tools.measure.timing import interleaved

BODIES = (4, 8, 16, 32, 64, 128)
LOOPS = {"pairs": ("-DPAIRS",), "packed": (), "packed, 512 bits": ("-mprefer-vector-width=512",)}
#: Pairs of one run.
WORK = 200_000


def measured(n: int, folder: Path, *, repeats: int = 9) -> dict[str, float]:
    """Return microseconds of one evaluation, by the names of :data:`LOOPS`.

    Raises
    ------
    ArithmeticError
        Where the loops differ.
    """
    random = np.random.default_rng(1)
    places, masses = random.standard_normal(3 * n), random.random(n) / n
    times = max(1, WORK // n**2)
    ends = {}

    def of(name: str) -> object:
        loop = built("bodies", "BODIES", folder, *LOOPS[name])

        def run() -> None:
            q = places.copy()
            loop(q.ctypes.data, masses.ctypes.data, float(n), times)
            ends[name] = q

        return run

    spent = interleaved({name: of(name) for name in LOOPS}, repeats)  # type: ignore[misc]
    if any((q != ends["pairs"]).any() for q in ends.values()):
        raise ArithmeticError(f"the loops over {n} bodies differ")
    return {name: 1e6 * min(found) / times for name, found in spent.items()}


def main() -> None:
    """Print the table."""
    heads = ("bodies", *(f"{name}, µs" for name in LOOPS), "pairs / packed")
    sys.stdout.write(f"| {' | '.join(heads)} |\n|{' --- |' * len(heads)}\n")
    with tempfile.TemporaryDirectory() as folder:
        for n in BODIES:
            found = measured(n, Path(folder))
            best = min(found[name] for name in LOOPS if name != "pairs")
            cells = [str(n), *(f"{x:.3g}" for x in found.values()), f"{found['pairs'] / best:.2f}"]
            sys.stdout.write(f"| {' | '.join(cells)} |\n")


if __name__ == "__main__":
    main()
