"""What the general reader misses is counted with its reason."""

from __future__ import annotations

import pytest

from glmref.audit.lexer import LANGUAGES
from glmref.audit.recognising import tables
from tools.audit_recall import Seen, compared

RK4 = (
    "# Runge-Kutta\nclass Kutta:\n    order = 4\n"
    "    A = [[0, 0, 0, 0], [1 / 2, 0, 0, 0], [0, 1 / 2, 0, 0], [0, 0, 1, 0]]\n"
    "    b = [1 / 6, 1 / 3, 1 / 3, 1 / 6]\n"
)


@pytest.mark.parametrize(
    ("change", "seen"),
    [
        (("", ""), Seen.ALIKE),
        (("order = 4", "pass"), Seen.NO_ORDER),
        (("order = 4", "order = 3"), Seen.OTHER_ORDER),
        (("1 / 3, 1 / 3", "1 / 2, 1 / 6"), Seen.OTHER),
        (("1 / 3, 1 / 3", "1 / 3, weight()"), Seen.SAID),
        (("    A = [[", "    # [["), Seen.SILENT),
    ],
)
def test_what_differs_has_its_reason(change: tuple[str, str], seen: Seen) -> None:
    special, general = (
        tables(x, LANGUAGES["python"], about=True) for x in (RK4, RK4.replace(*change))
    )
    assert [x for _, x in compared(special, general)] == [seen]


def test_an_order_that_only_the_general_reader_sees_is_more() -> None:
    special, general = (
        tables(x, LANGUAGES["python"], about=True) for x in (RK4.replace("order = 4", "pass"), RK4)
    )
    assert [x for _, x in compared(special, general)] == [Seen.MORE]


def test_what_a_special_reader_does_not_read_is_not_counted() -> None:
    text = RK4.replace("1 / 3, 1 / 3", "1 / 3, weight()")
    assert list(compared(tables(text, LANGUAGES["python"], about=True), [])) == []
