"""A sample of the mutants of the judge's hypotheses; a mutant is drawn by its text."""

import pytest

from . import judge_mutation


@pytest.mark.slow
def test_a_hypothesis_of_the_judge_that_is_dropped_or_negated_is_noticed() -> None:
    counts, alive = judge_mutation.survivors((), 40)
    assert not alive
    assert counts["hypotheses drawn"] > 4
