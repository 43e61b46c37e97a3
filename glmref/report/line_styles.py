"""One look for each method in all pictures of a report.

The look is a number: its rest modulo 7, 8 and 5 is the colour, the mark and the dash of a line, so
that 280 looks differ. Methods of one picture have different colours as long as there are enough,
then lines of one colour different dashes, then different marks.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence, Set

_COLOURS, _MARKS, _DASHES, _LOOKS = 7, 8, 5, 280


def looks(pictures: Iterable[Sequence[str]], methods: Set[str]) -> dict[str, int]:
    """Return the number of the look of every line of the pictures, in any order of these.

    Lines whose names, separated by commas, hold one of the known methods have its look.
    """
    of: dict[str, str] = {}
    beside: dict[str, set[str]] = {}
    for lines in pictures:
        here = {line: _subject(line, methods) for line in lines}
        of |= here
        for one in here.values():
            beside.setdefault(one, set()).update(here.values())
    chosen: dict[str, int] = {}
    used: Counter[int] = Counter()
    # those with the most neighbours first: they are the hardest to place
    for one in sorted(beside, key=lambda x: (-len(beside[x]), x)):
        near = [chosen[x] for x in beside[one] if x in chosen]
        colours = Counter(k % _COLOURS for k in near)
        marks = Counter(k % _MARKS for k in near)
        dashes = Counter((k % _COLOURS, k % _DASHES) for k in near)
        taken = set(near)
        chosen[one] = min(
            range(_LOOKS),
            key=lambda k: (
                k in taken,
                colours[k % _COLOURS],
                dashes[k % _COLOURS, k % _DASHES],
                marks[k % _MARKS],
                used[k],
                k,
            ),
        )
        used[chosen[one]] += 1
    return {line: chosen[one] for line, one in of.items()}


def _subject(line: str, methods: Set[str]) -> str:
    """Return the method that a line is about, or else the line without its step size."""
    parts = line.split(", ")
    found = next((x for x in parts if x in methods), None)
    return found or ", ".join(x for x in parts if not x.startswith("h = "))
