"""Every symplectic tableau agrees with the property its literature states.

What is published, by family; the property is computed here from the coefficients, not read from the
claims of the files.
"""

import re

import pytest

from glmref.catalogue.lookup import document, load, names
from glmref.prove.facts import facts_of

#: Pattern of names, whether the methods are symplectic, and who says so.
PUBLISHED = [
    (r"gauss-\d", True, "Sanz-Serna, BIT 28 (1988) 877; Lasagni, ZAMP 39 (1988) 952"),
    (r"radau-i{1,2}a-\d", False, "Hairer, Lubich, Wanner (2006), section VI.4: Gauss only"),
    (r"lobatto-iii[abc]-\d", False, "Jay, Lobatto methods, Encycl. Appl. Comput. Math. (2015)"),
    (r"lobatto-iiic-star-\d", False, "Jay (2015)"),
    (r"lobatto-iii[de]-\d", True, "Chan, Computing 45 (1990) 301; Jay (2015)"),
    (r"lobatto-iiia-iiib-\d", True, "Sun, J. Comput. Math. 11 (1993) 365; HLW, theorem IV.2.3"),
    (r"lobatto-iiic-iiic-star-\d", True, "Sun (1993); Jay (2015)"),
    (r"qin-zhang-2", True, "Qin and Zhang, J. Comput. Math. 10 Suppl. (1992) 42"),
    (r"suzuki-4|yoshida-4|triple-jump-6|yoshida-6-midpoint", True,
     "composition of a symplectic method, the midpoint rule: HLW, section II.4"),
    (r"trapezoidal", False, "conjugate to the midpoint rule and not symplectic: HLW, section VI.8"),
    (r"g4123", True, "Butcher and Imran, BIT 55 (2015) 927"),
    (r"g6245(-w3)?(-complex)?", True, "Butcher, Imran and Podhaisky, BIT 57 (2017) 313"),
    (r"gsymplectic-p", True, "Butcher, Habib, Hill and Norton, SIAM J. Numer. Anal. 52 (2014)"),
    (r"gsymplectic-n(-start-3-6|-pair)?|thesis-3-8", True, "Khan (2018), (3.5) and (3.8)"),
    (r"leapfrog(-one-leg)?|milne-(simpson|predictor)(-one-leg)?|am-1|implicit-midpoint", True,
     "symmetric one-leg methods and their multistep twins: Eirola and Sanz-Serna (1992)"),
    (r"ab-\d(-one-leg)?|am-[2-9]|bdf-\d(-one-leg)?|hamming|adams-nordsieck-\d", False,
     "only symmetric multistep methods conserve a form: Eirola and Sanz-Serna (1992)"),
]  # fmt: skip


def computed(name: str) -> bool | None:
    """What the coefficients say; with published decimals, up to their digits."""
    found = facts_of(load(name)).g_symplecticity
    return True if found.holds is None and found.residual < 1e-12 else found.holds


@pytest.mark.parametrize(
    ("pattern", "published", "source"), PUBLISHED, ids=[x[0] for x in PUBLISHED]
)
def test_a_family_has_the_published_property(pattern: str, published: bool, source: str) -> None:
    members = [name for name in names("methods") if re.fullmatch(pattern, name)]
    assert members, source
    assert {name: computed(name) for name in members} == dict.fromkeys(members, published), source


def test_every_tableau_that_conserves_a_form_has_a_published_property_or_is_ours() -> None:
    """The list above is complete: what it lacks are splittings and methods derived here."""
    missing = [
        name
        for name in names("methods")
        if (claims := document(name)["claims"]).get("symplectic") or claims.get("g-symplectic")
        if not any(re.fullmatch(pattern, name) for pattern, _, _ in PUBLISHED)
        if document(name)["class"] != "splitting"
        if not document(name)["source"]["citation"].startswith("glmref, derived")
    ]
    assert missing == []


@pytest.mark.slow
def test_no_explicit_runge_kutta_method_is_symplectic() -> None:
    """Sanz-Serna (1988): b_i a_ij + b_j a_ji = b_i b_j with i = j asks for a_ii = b_i / 2."""
    explicit = [
        name
        for name in names("methods")
        if document(name)["class"] in ("rk", "composition") and load(name).is_explicit
    ]
    assert len(explicit) >= 25
    assert {name: computed(name) for name in explicit} == dict.fromkeys(explicit, False)


@pytest.mark.slow
def test_every_splitting_is_symplectic() -> None:
    """Each update is the exact flow of one part: Ruth, IEEE NS-30 (1983) 2669; HLW, II.5."""
    splittings = [name for name in names("methods") if document(name)["class"] == "splitting"]
    assert len(splittings) >= 6
    assert {name: computed(name) for name in splittings} == dict.fromkeys(splittings, True)


def test_the_gauss_property_is_lost_with_one_digit() -> None:
    assert computed("gauss-3") is True
    assert computed("gauss-3-sign") is False
