"""A sample of the mutants of the kernel, of the table of implications, and of the judge's hypotheses.

A mutant is drawn by its text, one in 23. Those that no case can notice are named in
:data:`tests.adversary.mutation.EQUIVALENT`, with the reason.
"""

from __future__ import annotations

import subprocess
import sys

import pytest

from . import judge_mutation
from .mutation import EQUIVALENT, RULES, Cases, sample

#: In a process of its own: a test module that is imported already keeps the names of the kernel
#: without the change.
ALIVE = "from tests.adversary.mutation import survivors; print(*survivors(23), sep='\\n', end='')"


@pytest.mark.slow
def test_every_mutant_of_a_sample_is_noticed() -> None:
    run = subprocess.run([sys.executable, "-c", ALIVE], capture_output=True, text=True)
    assert (run.returncode, run.stdout) == (0, ""), run.stderr


@pytest.mark.slow
def test_a_hypothesis_of_the_judge_that_is_dropped_or_negated_is_noticed() -> None:
    counts, alive = judge_mutation.survivors((), 40)
    assert not alive
    assert counts["hypotheses drawn"] > 4


@pytest.mark.slow
def test_the_sample_is_no_empty_one() -> None:
    drawn = [label.partition(": ")[2] for _, label, _ in sample(23)]
    assert len(drawn) >= 15
    assert len(set(drawn) - EQUIVALENT.keys()) >= 12


@pytest.mark.slow
def test_a_module_without_a_change_is_not_noticed() -> None:
    bench = Cases()
    assert not any(bench.notices(name, None) for name in RULES)
