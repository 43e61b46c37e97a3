"""Every claim of every shipped file, recomputed; every broken file refuted for its reason."""

import pytest

from glmref.catalogue.lookup import document, load, names
from glmref.findings import Proof, Verdict
from glmref.method import Method
from glmref.prove.verifier import verify_file
from glmref.theory.order import OrderResult, highest_order, order_of

from .stored import RENEW, same, stored

#: What the thesis of Khan (2018) names, by the name of its file.
NAMED_BY_THE_THESIS = """
    euler rk4 gauss-2 ab-1 ab-2 ab-3 ab-4 ab-5 ab-6 am-1 am-2 am-3 am-4 am-5 am-6 leapfrog
    leapfrog-one-leg symplectic-euler-a symplectic-euler-b stormer-verlet gsymplectic-n
    gsymplectic-p thesis-3-8 s4-symmetric g6245-w3 g6245 g4123
""".split()


@pytest.mark.sampled(1, besides=("feagin", "g6245", "tanaka"))
@pytest.mark.parametrize("name", names("methods"))
def test_every_claim_of_a_method_holds(name: str) -> None:
    findings = verify_file(name)
    assert findings
    assert [f for f in findings if f.verdict is not Verdict.HOLDS] == []
    decisive = {"order", "order-identity", "g-symplectic", "symplectic", "symmetric", "growth"}
    measured = {f.claim for f in findings if f.proof is Proof.MEASURED}
    if "digits" not in document(name) or "enclosure" in document(name):
        assert not measured & decisive
    assert same(stored(name), [f.as_json() for f in findings]), RENEW


@pytest.mark.sampled(20, whole=len(names("broken")))
@pytest.mark.parametrize("name", names("broken"))
def test_a_broken_file_is_refuted_for_the_declared_reason(name: str) -> None:
    (finding,) = verify_file(name)
    assert finding.verdict is Verdict.HOLDS, finding
    assert finding.claim == f"refutes {document(name)['broken']['claim']}"
    assert same(stored(name), [finding.as_json()]), RENEW


def order_found(method: Method) -> OrderResult:
    """With the identity as principal part, or a free one where that reaches more."""
    same = order_of(method, principal="identity")
    free = same if method.is_one_step else order_of(method, principal="free")
    return same if free.order == same.order else free


@pytest.mark.sampled(6, besides=("s5t", "s5i", "multistep-", "multivalue-"))
@pytest.mark.parametrize("name", names("methods"))
def test_the_order_is_exact_and_one_more_fails_at_a_named_tree(name: str) -> None:
    method = load(name)
    result = order_found(method)
    if result.at_least:  # trees are listed so far; beyond, the kernel decides by paths
        assert result.order == highest_order(method.palette) <= document(name)["claims"]["order"]
        return
    assert result.failing_tree.order == result.order + 1
    assert result.residual.is_zero() is False


def test_the_catalogue_is_as_large_as_promised() -> None:
    assert len(names("methods")) >= 60
    assert len(names("broken")) >= 20
    assert 3 * len(names("broken")) >= len(names("all"))


@pytest.mark.parametrize("name", NAMED_BY_THE_THESIS)
def test_methods_the_thesis_names_are_there(name: str) -> None:
    assert name in names("methods")
