"""Which steps are taken and kept: the numbers, and every sentence of what cannot be."""

import math
from typing import Any

import pytest

from glmref import Problem, UsageError
from glmref.engine.plan import MOST_STEPS, Grid, plan_of
from tests.build import refused

OF = Problem(f=("y[0]",), y0=(1.0,), t_span=(1.0, 2.0))


def planned(h: float = 0.25, of: Problem = OF, **given: Any) -> tuple[int, int, list[int], bool]:
    keys = ("t_end", "steps", "every", "times", "limit")
    assert set(given) <= set(keys)
    found = plan_of(of, h, *(given.get(key) for key in keys))
    return found.steps, found.every, list(found.rows), found.limited


def test_time_that_stands_still_at_the_end_is_refused() -> None:
    of = Problem(f=("y[0]",), y0=(1.0,), t_span=(0.0, 1.0))
    late = Problem(f=("y[0]",), y0=(1.0,), t_span=(2.0**53 - 10, 2.0**53))
    assert planned(1.0, late, steps=9)[0] == 9
    lost = r"h = 1.0 is lost in rounding when it is added to t = 9007199254741080.0"
    refused(UsageError, lost, planned, 1.0, late, steps=98)
    assert planned(1.0, of, steps=2**52)[0] == 2**52
    assert planned(1e-300, of, steps=3)[0] == 3
    assert planned(1e-17, OF, steps=0)[0] == 0


def test_a_grid_is_a_sequence() -> None:
    for last in range(8):
        for every in range(1, 6):
            wanted = sorted({*range(0, last + 1, every), last})
            grid = Grid(last, every)
            assert list(grid) == wanted and len(grid) == len(wanted)
            assert grid[:] == wanted and grid[1:3] == wanted[1:3] and grid[-1] == wanted[-1]
            assert [n for n in range(-3, last + 3) if n in grid] == wanted
            assert grid[-len(grid)] == wanted[0] and "0" not in grid
            for outside in (len(grid), -len(grid) - 1):
                with pytest.raises(IndexError):
                    grid[outside]


def test_so_many_steps_as_can_be_counted_are_counted():
    span = math.ldexp(1.0, 53)
    of = Problem(f=("y[0]",), y0=(1.0,), t_span=(0.0, 1.0))
    for given in ({"t_end": span}, {"steps": MOST_STEPS}):
        assert planned(1.0, of, **given) == (MOST_STEPS, 0, [MOST_STEPS], False)
    refused(UsageError, "can be counted", planned, 1.0, of, t_end=math.nextafter(span, math.inf))
