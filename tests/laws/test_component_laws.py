"""A method with one component, seen as one with two equal components, is the same method."""

import glmref
from glmref import PartitionedGLM
from glmref.prove.facts import facts_of


def test_one_method_as_a_pair_with_equal_blocks_gives_the_same_verdicts():
    for name in ("rk4", "gauss-2", "gsymplectic-n", "radau-iia-2"):
        m = glmref.load(name)
        pair = PartitionedGLM(*[getattr(m, x) for x in "AUBV"] * 2)
        single, double = facts_of(m.bare()), facts_of(pair)
        assert (
            single.kernel.range("order-identity").value
            == double.kernel.range("order-identity").value
        )
        for claim in ("preconsistent", "consistent", "zero-stable", "explicit", "symmetric"):
            assert single.truth(claim) is double.truth(claim), (name, claim)
        assert single.truth("g-symplectic") is double.truth("g-symplectic"), name
