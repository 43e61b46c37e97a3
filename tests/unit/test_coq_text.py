"""The text for Coq, read back: numbers, methods and witnesses are what the theorems are about.

Coq itself checks a few files in ``tests/repo/test_coq.py``; here the terms are evaluated in exact
numbers, and the identities that Coq computes are computed again.
"""

import re
from dataclasses import replace
from fractions import Fraction
from functools import cache, cached_property
from typing import Any

import pytest

from glmref import GLM, PartitionedGLM, load
from glmref.exact import Exact, linalg
from glmref.exact.expression import parse, to_text
from glmref.method import Method
from glmref.prove.coq import file_stem, main, to_coq
from glmref.theory.order import order_of
from glmref.theory.trees import Tree, tree
from tests.bseries import elementary_weights

#: Method -> the theorems of its file: a real field, a nested one, cubic roots, zero growth, pairs.
THEOREMS = {
    "rk4": ["order_4", "not_order_5"],
    "gauss-2": ["order_4", "not_order_5", "symplectic", "symmetric"],
    "gauss-3": ["order_6", "not_order_7", "symplectic", "symmetric"],
    "qin-zhang-2": ["order_2", "not_order_3", "symplectic", "symmetric"],
    "yoshida-4": ["order_4", "not_order_5", "symplectic", "symmetric"],
    "gsymplectic-n": [
        "order_identity_4", "order_4", "not_order_identity_5", "g_symplectic", "symmetric",
    ],
    "s4-symmetric": [
        "order_identity_4", "order_4", "not_order_identity_5", "g_symplectic", "symmetric",
        "no_growth",
    ],
    "bdf-2": ["order_identity_2", "order_2", "not_order_identity_3"],
    "butcher-effective-5": ["order_4", "not_order_5"],
    "stormer-verlet": ["order_identity_2", "order_2", "not_order_identity_3", "g_symplectic"],
    "g4123": ["order_4", "g_symplectic", "no_growth"],
    "lobatto-iiia-iiib-2": ["order_identity_2", "order_2", "not_order_identity_3", "g_symplectic"],
    "symplectic euler beside an idle value": ["order_2", "g_symplectic"],
    "midpoint rule of a general pair": [
        "order_identity_2", "order_2", "not_order_identity_3", "g_symplectic",
    ],
    "no order": ["not_order_1"],
    "no order of a pair": [],
    "complex weights": ["order_2", "not_order_3"],
    "euler beside a value that is kept": ["order_identity_1", "order_1", "no_growth"],
    "no order with two values": ["no_growth"],
    "a form of size three": ["order_2", "not_order_3", "symplectic", "symmetric"],
    "a form of size three of a pair": [
        "order_identity_1", "order_1", "not_order_identity_2", "g_symplectic",
    ],
}  # fmt: skip

ONE, KEPT = [["1"]], {"U": [["1", "0"]], "V": [["1", "0"], ["0", "1"]], "B": [["1"], ["0"]]}
IDLE = {"U": [["1", "0"]], "B": [["1"], ["0"]], "V": [["1", "0"], ["0", "0"]]}


def halves(A: list[list[str]], A_hat: list[list[str]], both: dict[str, Any]) -> dict[str, Any]:
    return {"A": A, "A_hat": A_hat, **both, **{f"{k}_hat": x for k, x in both.items()}}


#: Methods for which the catalogue has none.
SMALL: dict[str, Method] = {
    "symplectic euler beside an idle value": PartitionedGLM(
        **halves([["0"]], ONE, IDLE), separable=True
    ),
    "midpoint rule of a general pair": PartitionedGLM(
        **halves([["1/2"]], [["1/2"]], {"U": ONE, "B": ONE, "V": ONE}), separable=False
    ),
    "no order": GLM(A=[["0"]], U=ONE, B=[["1/2"]], V=ONE),
    "no order of a pair": PartitionedGLM(
        **halves([["0"]], ONE, {"U": ONE, "B": [["1/2"]], "V": ONE}), separable=True
    ),
    "complex weights": GLM(
        A=[["0", "0"], ["1/4+i/4", "0"]], U=[["1"], ["1"]], B=[["i", "1-i"]], V=ONE
    ),
    "euler beside a value that is kept": GLM(A=[["0"]], **KEPT),
    "a form of size three": GLM(A=[["1/2"]], U=ONE, B=ONE, V=ONE, G=[["3"]], D=["3"]),
    "a form of size three of a pair": PartitionedGLM(
        **halves([["0"]], ONE, {"U": ONE, "B": ONE, "V": ONE}),
        G=[["3"]],
        D_P=["3"],
        D_Q=["3"],
        separable=True,
    ),
    "no order with two values": GLM(A=[["0"]], **{**IDLE, "B": [["1/2"], ["0"]]}),
}


class Text:
    """A file for Coq; terms are lists of words, numbers and terms."""

    def __init__(self, name: str) -> None:
        self.method = replace(SMALL[name], name=name) if name in SMALL else load(name)
        self.text = to_coq(self.method if name in SMALL else name)
        self.proofs = dict(re.findall(r"^Theorem (\w+) :.*?\n(.*?) Qed\.", self.text, re.M | re.S))

    def defined(self, name: str) -> list[Any]:
        (text,) = re.findall(rf"^Definition {name} : .*? :=\s(.*?)\.\n", self.text, re.M | re.S)
        return terms(text)

    def arguments(self, suffix: str) -> list[Any]:
        """What stands behind the rule in the proof of a theorem."""
        (proof,) = (text for name, text in self.proofs.items() if name.endswith(f"_{suffix}"))
        (text,) = re.findall(r"apply \((.*)\); vm_compute", proof, re.S)
        return terms(text)

    @cached_property
    def roots(self) -> list[Exact]:
        found: list[Exact] = []
        (levels,) = self.defined("T")
        for n, *radicand in reversed(levels):
            inner = self.number(radicand, found)
            found.append(inner.sqrt() if n == "2" else parse(f"root({to_text(inner)},{n})"))
        return found

    def number(self, term: Any, roots: list[Exact] | None = None) -> Exact:
        """Ext x y is x + root y, x without the last root; Rat n#d lies in every level."""
        roots = self.roots if roots is None else roots
        while len(term) == 1 and isinstance(term[0], list):
            (term,) = term
        if term[0] == "Rat":
            rational = term[1] if isinstance(term[1], str) else term[1][0]
            return Exact(Fraction(rational.replace("#", "/")))
        head, low, high = term
        assert head == "Ext"
        return self.number(low, roots[:-1]) + roots[-1] * self.number(high, roots)

    def vector(self, term: list[Any]) -> tuple[Exact, ...]:
        return tuple(map(self.number, term))

    def matrix(self, term: list[Any]) -> tuple[tuple[Exact, ...], ...]:
        return tuple(map(self.vector, term))

    def by_colour(self, name: str) -> dict[str, Any]:
        """A function of the colour: ``fun c => x`` or ``fun c => if c then x else y``."""
        _, _, _, *rest = self.defined(name)
        if rest[0] == "if":
            return {"k": rest[3], "f": rest[5]}
        return {"o": rest[0]}


def terms(text: str) -> list[Any]:
    """Words and lists: ``[a; b c]`` is [[a], [b, c]] where an item has words, ``(x)`` is [x]."""
    words = re.findall(r"[()\[\];,]|[^\s()\[\];,]+", text)

    def read(at: int, end: str) -> tuple[list[Any], int]:
        items: list[list[Any]] = [[]]
        while at < len(words) and words[at] != end:
            if words[at] in "([":
                inner, at = read(at + 1, ")" if words[at] == "(" else "]")
                items[-1].append(inner)
            elif words[at] == ";":
                items.append([])
            elif words[at] != ",":
                items[-1].append(words[at])
            at += 1
        if end != "]":
            return items[0], at
        if items == [[]]:
            return [], at
        alone = all(len(x) == 1 and isinstance(x[0], list) for x in items)
        return [x[0] for x in items] if alone else items, at

    return read(0, "")[0]


def grafted(term: Any) -> Tree:
    """A tree from its terms: the child joins those that are there."""
    while len(term) == 1:
        (term,) = term
    colours = {"tt": "o", "false": "f", "true": "k"}
    if term[0] == "leaf":
        return tree((), colours[term[2]])
    old, child = map(grafted, term[1:])
    return tree((*old.children, child), old.colour)


def same(x: Any, y: Any) -> bool:
    rows = zip(x, y, strict=True)
    return all((a - b).is_zero() if isinstance(a, Exact) else same(a, b) for a, b in rows)


written = cache(Text)
T, product = linalg.transpose, linalg.matmul


def about(*beginnings: str) -> pytest.MarkDecorator:
    """The methods of whose file a theorem is tested."""
    chosen = [k for k, names in THEOREMS.items() if any(x.startswith(beginnings) for x in names)]
    return pytest.mark.parametrize("text", chosen, indirect=True)


@pytest.fixture
def text(request: pytest.FixtureRequest) -> Text:
    return written(request.param)


@pytest.mark.parametrize("text", THEOREMS, indirect=True)
def test_the_theorems_are_those_of_the_method(text: Text) -> None:
    stem = file_stem(text.method.name)
    assert list(text.proofs) == [f"{stem}_{x}" for x in THEOREMS[text.method.name]]
    assert re.findall(r"^Print Assumptions (\w+)\.", text.text, re.M) == list(text.proofs)
    assert "(*" not in text.text.replace("(* ", "")


@pytest.mark.parametrize("text", THEOREMS, indirect=True)
def test_the_tableau_is_that_of_the_method(text: Text) -> None:
    m = text.method
    if m.is_one_step and len(m.components) == 1:
        assert same(text.matrix(text.defined("a")[0]), m.A)
        assert same(text.vector(text.defined("b")[0]), m.B[0])
        return
    names = ("M",) if len(m.components) == 1 else ("Mq", "Mp")
    for name, component in zip(names, m.components, strict=True):
        _, _, *matrices, stages = text.defined(name)
        assert int(stages) == len(component.B[0])
        for found, given in zip(matrices, component.matrices, strict=True):
            assert same(text.matrix(found), given)


@about("order_identity", "no_growth")
def test_the_starting_series_is_the_one_that_was_found(text: Text) -> None:
    principal = "identity" if "order_identity" in text.text else "free"
    eta = order_of(text.method, principal=principal).eta
    if eta is None:
        assert "Definition eta" not in text.text
        return
    found = {grafted(t): text.vector(x) for *t, x in text.defined("eta")[0]}
    assert set(found) == set(eta.support())
    assert all(same(x, eta[t]) for t, x in found.items())
    for colour, u in text.by_colour("u").items():
        assert same(text.vector(u), eta.empty(colour))


@about("not_order")
def test_the_next_order_fails_at_the_tree_with_that_defect(text: Text) -> None:
    name = next(x for x in THEOREMS[text.method.name] if x.startswith("not_order"))
    *_, p, t, last = found = text.arguments(name)
    m = text.method
    if name.startswith("not_order_identity"):
        *_, p, t, w, last = found
        t, w = grafted(t), text.vector(w)
        V, eta = {c.colour: c.V for c in m.components}, order_of(m, principal="identity").eta
        assert same(linalg.matvec(T(V[t.colour]), w), w)
        residual = order_of(m, principal="identity").residual
        seen = linalg.dot(w, eta.empty(t.colour))
        assert (text.number(last) * residual * seen - 1).is_zero()
        assert t.order == int(p) + 1
        for colour, Z in text.by_colour("Z").items():
            unit = linalg.identity(len(V[colour]))
            a = [[x] for x in text.vector(text.by_colour("a")[colour])]
            assert same(linalg.add(product(text.matrix(Z), linalg.sub(unit, V[colour])),
                                   product(a, unit[:1])), unit)  # fmt: skip
        return
    t = grafted(t)
    weight = elementary_weights(m.A, m.B[0], t.order)[t]
    assert t.order == int(p)
    assert (text.number(last) * (weight - Exact(1) / t.density) - 1).is_zero()


@about("symplectic", "g_symplectic")
def test_the_form_keeps_the_bilinear_identities(text: Text) -> None:
    name = next(x for x in THEOREMS[text.method.name] if "symplectic" in x)
    *_, G, D, u, size = found = text.arguments(name)
    q = p = text.method.components[0]
    v, D_P, D_Q = u, D, D
    if len(text.method.components) == 2:
        *_, G, D_P, D_Q, u, v, size = found
        q, p = text.method.components
    G, u, v, D_P, D_Q = text.matrix(G), *map(text.vector, (u, v, D_P, D_Q))

    def scaled(D: Any, A: Any) -> Any:
        return tuple(tuple(d * x for x in row) for d, row in zip(D, A, strict=True))

    assert same(product(T(q.V), product(G, p.V)), G)
    assert same(product(T(q.B), product(G, p.V)), scaled(D_P, p.U))
    assert same(product(T(q.B), product(G, p.B)), linalg.add(scaled(D_P, p.A), T(scaled(D_Q, q.A))))
    assert same(linalg.matvec(q.V, u), u)
    assert same(linalg.matvec(p.V, v), v)
    assert (text.number(size) * linalg.dot(u, linalg.matvec(G, v)) - 1).is_zero()


@about("symmetric")
def test_the_involution_turns_the_method_round(text: Text) -> None:
    *_, L, W, P = text.arguments("symmetric")
    m, L, W, P = text.method, text.matrix(L), text.matrix(W), [int(x) for (x,) in P]
    assert same(product(m.V, W), linalg.identity(m.r))
    assert same(product(L, product(W, L)), m.V)
    turned = product(m.U, product(W, m.B))
    total = [[m.A[i][j] + m.A[P[i]][P[j]] for j in range(m.s)] for i in range(m.s)]
    assert same(total, turned)


@about("no_growth")
def test_no_component_grows(text: Text) -> None:
    *_, X, u, y = text.arguments("no_growth")
    X, u, y, m = text.matrix(X), text.vector(u), text.vector(y), text.method
    outer = tuple(tuple(a * b for b in y) for a in u)
    moved = linalg.sub(product(m.V, X), product(X, m.V))
    assert same(product(m.B, m.U), linalg.add(moved, outer))
    assert same(linalg.matvec(m.V, u), u)


@pytest.mark.parametrize(
    ("name", "said"),
    [("s3-w3", "decimal"), ("ars-2-2-2", "additive"), ("ros3p", "Rosenbrock"), ("rk-9", "rk-9")],
)
def test_what_cannot_be_written_is_refused_in_one_sentence(name, said, capsys):
    assert main([name]) == 2
    output = capsys.readouterr()
    assert said in output.err
    assert "Traceback" not in output.err
    assert not output.out


def test_a_folder_gets_one_file_for_each_name(tmp_path, capsys):
    folder = tmp_path / "new" / "folders"
    assert main(["euler", "rk4", "--output", str(folder)]) == 0
    assert sorted(x.name for x in folder.iterdir()) == ["m_euler.v", "m_rk4.v"]
    assert (folder / "m_rk4.v").read_text(encoding="utf-8") == to_coq("rk4")
    assert main(["euler"]) == 0
    assert capsys.readouterr().out == to_coq("euler")


def test_a_title_cannot_end_its_comment() -> None:
    method = load("euler")
    document = {**(method.document or {}), "title": 'x *) Axiom a : False. (* "y"'}
    object.__setattr__(method, "document", document)
    head = to_coq(method).split("From Coq")[0]
    assert head.count("*)") == head.count("(*") == 1
    assert '"' not in head
