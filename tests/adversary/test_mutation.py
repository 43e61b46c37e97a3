"""A sample of the mutants of the kernel and of the table of implications: all are noticed.

A mutant is drawn by its text, one in 23. Those that no case can notice are named in
:data:`tests.adversary.mutation.EQUIVALENT`, with the reason.
"""

from __future__ import annotations

import pytest

from .mutation import EQUIVALENT, sample, survivors


@pytest.mark.slow
def test_every_mutant_of_a_sample_is_noticed() -> None:
    assert survivors(23) == []


@pytest.mark.slow
def test_the_sample_is_no_empty_one() -> None:
    drawn = [label.partition(": ")[2] for _, label, _ in sample(23)]
    assert len(drawn) >= 15
    assert len(set(drawn) - EQUIVALENT.keys()) >= 12
