"""Whatever the document, the loader gives a method or one sentence; and so does the parser."""

import copy
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from hypothesis import HealthCheck, assume, example, given, settings
from hypothesis import strategies as st

from glmref.catalogue.claims import CLAIMS
from glmref.catalogue.keys import BLOCKS, COMMON
from glmref.catalogue.lookup import document, names
from glmref.catalogue.reader import load_document
from glmref.catalogue.strict_json import read_json
from glmref.errors import DataError
from glmref.exact import Ball, Exact
from glmref.exact.expression import parse
from glmref.method import GLM, PartitionedGLM
from tests.build import SOURCE
from tests.examples import examples

#: One small document of each class, with and without starting methods, constants, decimals.
BASES = (
    *("gsymplectic-n", "gauss-2", "ab-2", "leapfrog-one-leg", "stormer-verlet", "yoshida-4"),
    *("gsymplectic-n-pair", "lobatto-iiia-iiib-2", "gauss-2-seven-digits", "g6245", "s5t-w3"),
)
KEYS = sorted({*COMMON, *CLAIMS, *(key for block in BLOCKS.values() for key in block)})

texts = st.one_of(
    st.sampled_from(["", "0", "1/2", "-1", "1/0", "sqrt(2)", "i", "x", "1e9", "0.5", "((1", "glm"]),
    st.text(alphabet="0123456789+-*/()., isqrtoexp_", max_size=12),
    st.text(max_size=6),
)
scalars = st.one_of(
    st.none(), st.booleans(), st.integers(-3, 300), st.floats(), st.integers(), texts
)
values = st.recursive(
    scalars,
    lambda inner: (
        st.lists(inner, max_size=4)
        | st.dictionaries(st.sampled_from(KEYS) | texts, inner, max_size=4)
    ),
    max_leaves=12,
)


def places(value: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """Every place in a document: of the object itself, its members, their members ..."""
    found = [path]
    if isinstance(value, dict):
        items: Any = value.items()
    elif isinstance(value, list):
        items = enumerate(value)
    else:
        items = ()
    for key, inner in items:
        found += places(inner, (*path, key))
    return found


@st.composite
def mutated(draw: st.DrawFn) -> Any:
    """A valid document with one to three places changed, taken out, doubled or renamed."""
    doc = copy.deepcopy(dict(document(draw(st.sampled_from(BASES)))))
    for _ in range(draw(st.integers(1, 3))):
        *path, last = draw(st.sampled_from(places(doc)[1:]))
        holder: Any = doc
        for key in path:
            holder = holder[key]
        kind = draw(st.sampled_from(["replace", "remove", "double", "rename"]))
        if kind == "replace":
            holder[last] = draw(values)
        elif kind == "remove":
            del holder[last]
        elif kind == "double":
            holder[last] = [holder[last], holder[last]]
        elif isinstance(holder, dict):
            holder[draw(st.sampled_from(KEYS) | texts)] = holder.pop(last)
        assume(len(places(doc)) > 1)
    return doc


def outcome(function: Callable[[], Any]) -> Any:
    """What a function returns, or the DataError it raises; any other error is a failure."""
    try:
        return function()
    except DataError as error:
        return error


def loads_or_says_why(doc: Any) -> None:
    result = outcome(lambda: load_document(doc, where="fuzz.json"))
    if isinstance(result, DataError):
        assert str(result).startswith("fuzz.json: ")
    else:
        assert isinstance(result, GLM | PartitionedGLM)


FUZZ = settings(examples(100), suppress_health_check=[HealthCheck.filter_too_much])


@FUZZ
@given(mutated())
def test_a_mutated_document_loads_or_gives_a_data_error(doc: Any) -> None:
    loads_or_says_why(doc)


@FUZZ
@given(values)
@example({})
@example({"class": []})
@example({"format": "glmref-method-2", "class": {}, "name": "x", "claims": {}, "source": {}})
@example({"format": "glmref-method-1", "class": "glm", "name": "x", "claims": {}, "source": {}})
def test_random_json_gives_a_data_error(doc: Any) -> None:
    loads_or_says_why(doc)


@examples(60)
@given(st.sampled_from(sorted(BLOCKS)), st.dictionaries(st.sampled_from(KEYS), values, max_size=8))
def test_a_document_of_random_members_gives_a_data_error(kind: str, members: Any) -> None:
    head = {"format": "glmref-method-1", "class": kind, "name": "fuzz"}
    loads_or_says_why({**head, "claims": {"order": 1}, "source": SOURCE, **members})


@examples(200)
@given(st.sampled_from(BASES), st.data())
def test_a_file_with_changed_bytes_reads_or_gives_a_data_error(tmp_path_factory, base, data):
    content = bytearray(json.dumps(document(base)).encode())
    for _ in range(data.draw(st.integers(1, 4))):
        at = data.draw(st.integers(0, len(content) - 1))
        piece = data.draw(
            st.binary(max_size=3) | st.sampled_from([b"[", b'"', b"\\", b"{", b"0.5"])
        )
        content[at : at + data.draw(st.integers(0, 2))] = piece
    path = Path(tmp_path_factory.getbasetemp()) / "fuzz.json"
    path.write_bytes(bytes(content))
    doc = outcome(lambda: read_json(path))
    if isinstance(doc, DataError):
        assert str(doc).startswith("fuzz.json: ")
    else:
        loads_or_says_why(doc)


@examples(200)
@given(
    st.text(alphabet="0123456789+-*/()., \t_isqrtoexpc", max_size=40) | st.text(max_size=20),
    st.sampled_from([None, 3]),
)
@example("exp(exp(2*pi*i/3))", None)
@example("root(2,3,4)", None)
@example("sqrt()", None)
@example("1/sqrt(0.000)", 3)
@example("exp(0.5)", 3)
@example("-" * 50, None)
def test_any_text_is_a_number_or_a_data_error(text: str, digits: int | None) -> None:
    value = outcome(lambda: parse(text, constants={"c": Exact(2).sqrt()}, digits=digits))
    if isinstance(value, DataError):
        assert "write integers" in str(value) or "write all of them" in str(value)
        assert "\n" not in str(value)
    else:
        assert isinstance(value, Exact | Ball)
        assert value.magnitude() >= 0


def test_every_shipped_document_survives_a_json_round_trip() -> None:
    for name in names("all"):
        doc = document(name)
        assert json.loads(json.dumps(doc)) == doc
