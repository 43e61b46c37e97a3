"""Order 6 with stage order 2 and the identity start at a rational c2 and a non-real z, exactly.

The construction of Khan (2018), section 3.4, with its equations solved as they stand (tableau,
forms and the test of admissibility: :mod:`glmref.derive.recipes.order6_family`). An explicit start
of 17 stages is solved for and added where rough parameters are on record, for c2 = 1/3 and 3/10;
``start`` is ``yes`` (refuse where there is none), ``no`` or ``auto``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

from ...catalogue.claims import SECOND_ORDER_GROWTH
from ...catalogue.reader import load_document
from ...catalogue.writer import SYMMETRIC
from ...errors import UsageError
from ...exact import Exact
from ...exact.expression import parse, to_text
from ...findings import Proof
from ...prove.starting import target_of
from ...system.arguments import one_of
from ...theory.second_order import second_order
from ..recognise import exact_text
from .derivation import Derivation, Progress, Statement, proved_exactly, rational_option
from .order6_family import Family, Forms, family, least_growth, solve_forms
from .solved import rough_starts, with_start
from .sources import GROWS, derived_source, long_notes, thesis_source

OPTIONS: Mapping[str, str] = {"c2": "1/3", "z": "exp(2*pi*i/3)", "start": "auto"}

_W3 = "exp(2*pi*i/3)"


def derive(options: Mapping[str, str], progress: Progress) -> Derivation:
    """Derive the method at ``c2`` and ``z``, or prove that there is none.

    Raises
    ------
    UsageError
        For a c2 that is not rational or at a pole, a z off the unit circle, or a requested
        start that is not on record.
    """
    start = one_of("start", options["start"], ("auto", "yes", "no"))
    c2, z = rational_option("c2", options["c2"]), _unit(options["z"])
    progress("tableau", 0, 3)
    member = family(c2)
    candidates = solve_forms(member)
    progress("forms", 1, 3)
    forms = next((x for x in candidates if x.is_real()), None)
    if forms is None:
        return _refusal(member, candidates)
    document = _document(member, forms, options["z"].replace(" ", ""), z)
    invariants = second_order(load_document(document, where=document["name"]))
    found = [to_text(y) for x in invariants for y in (x.I1, x.I3)]
    document["claims"][SECOND_ORDER_GROWTH.key] = found
    progress("proof", 2, 3)
    statements = [proved_exactly(document)]
    on_record = document["name"] in rough_starts()
    if start == "yes" and not on_record:
        raise UsageError(f"no start is on record for {document['name']}: derive without `start`")
    if on_record and start != "no":
        document, more = _started(document)
        statements.append(more)
    progress("done", 3, 3)
    return Derivation("order6", [document], statements)


def _started(document: Mapping[str, Any]) -> tuple[dict[str, Any], Statement]:
    """Add the explicit start on record."""
    method = load_document(document, where=document["name"])
    result = with_start(document, target_of(document, method), 1)
    text = (
        f"{document['name']}: explicit start of {len(result['starting']['A'])} stages exact within "
        "the digits on all trees of order 6 or less"
    )
    return result, Statement(text, Proof.ENCLOSED)


def _unit(text: str) -> Exact:
    z = parse(text)
    if not isinstance(z, Exact) or z * z.conjugate() != 1 or z.is_real():
        raise UsageError(f"`z` must lie on the unit circle and not be real, got {text!r}")
    return z


def _refusal(member: Family, candidates: Sequence[Forms]) -> Derivation:
    """Say exactly why no real forms exist at this c2."""
    statements: list[Statement] = []
    b1, b2, b3 = member.b[:3]
    if not candidates:
        text = f"c2 = {member.c2}: -b1 b2 b3 = {-b1 * b2 * b3} < 0: no real gamma without growth"
        statements.append(Statement(text, Proof.EXACT))
    for x in candidates:
        squares = {
            "alpha1^2": Exact(x.alpha_square),
            "beta1^2": x.beta_square.exact(),
            "gamma1^2": x.gamma_square.exact(),
        }
        wrong = [f"{name} = {float(v):.6g}" for name, v in squares.items() if v.sign() <= 0]
        direction = x.gamma_ratios[0].quotient_text()
        text = (
            f"c2 = {member.c2}, gamma2/gamma1 = {direction}: {', '.join(wrong)}, must be positive"
        )
        statements.append(Statement(text, Proof.EXACT))
    least = least_growth(member)
    if least is not None:
        text = (
            f"c2 = {member.c2}: all real alpha, beta, gamma of this W, symmetric or not, have a "
            f"growth parameter of {least.ball().decimal_text(12)} or more, in absolute value, at -1"
        )
        statements.append(Statement(text, Proof.ENCLOSED))
    return Derivation("order6", [], statements, refused=True)


#: How much the parasitic part grows in data/measurements/long-runs.json, in a word.
_GROWTH = {"g6245-w3": "thirtyfold", "c2-3-10-w3": "thirtyfold"}


def _document(member: Family, forms: Forms, z_text: str, z: Exact) -> dict[str, Any]:
    b = [str(x) for x in member.b]
    alpha1 = Exact(forms.alpha_square).sqrt()
    half, name = z_text == "i", _name(member.c2, z_text)
    said = [GROWS.format(_GROWTH[name])] if name in _GROWTH else []
    said += long_notes(name)
    notes = {"notes": said} if said else {}
    return {
        "format": "glmref-method-1",
        "name": name,
        "title": _title(member.c2, z_text),
        "class": "glm",
        **notes,
        "constants": {
            "alpha1": exact_text(alpha1),
            "alpha2": exact_text(alpha1 * forms.alpha_ratio),
            "beta1": f"sqrt({forms.beta_square.quotient_text()})",
            "beta2": forms.beta_ratios[0].factor_text("beta1"),
            "beta3": forms.beta_ratios[1].factor_text("beta1"),
            "gamma1": f"sqrt({forms.gamma_square.quotient_text()})",
            "gamma2": forms.gamma_ratios[0].factor_text("gamma1"),
            "gamma3": forms.gamma_ratios[1].factor_text("gamma1"),
        },
        "A": [[str(x) for x in row] for row in member.A],
        "U": [_u_row(i, z_text, z) for i in range(5)],
        "B": [b, *_b_rows(member.b, 1 if half else 2), _times(member.b, 1, "gamma")],
        "V": _rotation(z),
        "G": _diagonal(["1", "-1", "-1", "1"] if half else ["1", "-1/4", "-1/4", "1"]),
        "D": b,
        "claims": {
            "order": 6,
            "order-identity": 6,
            "stage-order": 2,
            "abscissae": [str(x) for x in member.c],
            **SYMMETRIC,
            "conjugate-symplectic": True,
            "hamiltonian-to-order": 6,
            "energy-order": 6,
            "explicit": False,
            "growth": ["0", "0", "0"],
        },
        "source": _source(member.c2, z_text),
    }


def _diagonal(values: Sequence[str]) -> list[list[str]]:
    return [[x if i == j else "0" for j in range(len(values))] for i, x in enumerate(values)]


def _rotation(z: Exact) -> list[list[str]]:
    c, s, minus = exact_text(z.real), exact_text(z.imag), exact_text(-z.imag)
    rows = _diagonal(["1", c, c, "-1"])
    rows[1][2], rows[2][1] = minus, s
    return rows


def _times(b: Sequence[Fraction], factor: int, name: str) -> list[str]:
    """Return a row of B: weights times the symmetric gamma or beta."""
    return [f"{factor * x}*{name}{min(i, 4 - i) + 1}" for i, x in enumerate(b)]


def _b_rows(b: Sequence[Fraction], factor: int) -> list[list[str]]:
    alpha = [f"{factor * b[0]}*alpha1", f"{factor * b[1]}*alpha2", "0"]
    alpha += [f"{-factor * b[1]}*alpha2", f"{-factor * b[0]}*alpha1"]
    return [alpha, _times(b, factor, "beta")]


def _u_row(i: int, z_text: str, z: Exact) -> list[str]:
    """Return the row i of U: (1, Re and Im of -z conj(omega_i) or half of them, -gamma_i)."""
    k = min(i, 4 - i) + 1
    alpha, beta, gamma = f"alpha{k}", f"beta{k}", f"-gamma{k}"
    sign = "" if i < 2 else "-"
    if z_text == "i":
        return ["1", f"-{beta}", "0" if i == 2 else f"{sign}{alpha}", gamma]
    if z_text == _W3:
        if i == 2:
            return ["1", f"-sqrt(3)*{beta}/4", f"{beta}/4", gamma]
        second = f"(sqrt(3)*{alpha}+{beta})/4" if i < 2 else f"({beta}-sqrt(3)*{alpha})/4"
        return ["1", f"({sign}{alpha}-sqrt(3)*{beta})/4", second, gamma]
    c, s = f"({exact_text(z.real)})", f"({exact_text(z.imag)})"
    if i == 2:
        return ["1", f"-{s}*{beta}/2", f"-{c}*{beta}/2", gamma]
    other = "-" if i < 2 else ""
    first, second = f"({other}{c}*{alpha}-{s}*{beta})/2", f"({sign}{s}*{alpha}-{c}*{beta})/2"
    return ["1", first, second, gamma]


def _name(c2: Fraction, z_text: str) -> str:
    if c2 == Fraction(1, 3) and z_text in ("i", _W3):
        return "g6245" if z_text == "i" else "g6245-w3"
    where = {_W3: "w3", "i": "i"}.get(z_text, "z")
    return f"c2-{c2.numerator}-{c2.denominator}-{where}"


def _title(c2: Fraction, z_text: str) -> str:
    shown = {_W3: "exp(2 pi i/3)"}.get(z_text, z_text)
    what = "G-symplectic method G6245" if _name(c2, z_text) == "g6245" else "G-symplectic method"
    with_c2 = "" if c2 == Fraction(1, 3) else f" and c2 = {c2}"
    return f"{what} of order 6 with z = {shown}{with_c2}, symmetric and free of parasitism"


_ERRATA = (
    (
        "Section 3.4 prints a method with c2 = 1/15 that does not exist: its W has rank 5 instead "
        "of 3. The construction with c2 = 1/3 does."
    ),
    (
        "Printed U carries z = i; for z = exp(2 pi i/3) its rows are (1, -z conj(omega)/2, "
        "-conj(z) omega/2, -gamma)."
    ),
)
_BIP = {
    "citation": "Butcher, J. C., Imran, G. and Podhaisky, H., A G-symplectic method with order 6, "
    "BIT Numerical Mathematics 57 (2017), 313-328",
    "where": "the method G6245; Butcher (2021), section 7.6; beta and gamma in rational multiples "
    "of beta1 and gamma1",
    "status": "regenerated",
    "bibtex": "@article{bip2017,\n  author = {Butcher, J. C. and Imran, G. and Podhaisky, H.},\n  "
    "title = {{A G-symplectic method with order 6}},\n  journal = {BIT Numerical Mathematics},\n  "
    "volume = {57},\n  pages = {313--328},\n  year = {2017},\n}",
}


def _source(c2: Fraction, z_text: str) -> dict[str, Any]:
    name = _name(c2, z_text)
    if name == "g6245":
        return dict(_BIP)
    if name == "g6245-w3":
        where = "section 3.4, in the real form (3.7), with c2 = 1/3"
        return thesis_source(where, "corrected", _ERRATA)
    return derived_source(
        f"the construction of Khan (2018), section 3.4, with c2 = {c2}, its equations solved "
        "exactly"
    )
