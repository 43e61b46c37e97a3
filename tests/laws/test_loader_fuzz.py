"""Whatever the document, the loader gives a method or one sentence; and so does the parser."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from glmref.catalogue.claims import CLAIMS
from glmref.catalogue.keys import BLOCKS, COMMON
from glmref.catalogue.lookup import document, names
from glmref.catalogue.reader import load_document
from glmref.catalogue.strict_json import read_json
from glmref.errors import DataError
from glmref.exact import Ball, Exact
from glmref.exact.expression import parse
from tests.attack.files import case
from tests.build import SOURCE
from tests.examples import examples

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
        assert result.components


FUZZ = settings(examples(100), suppress_health_check=[HealthCheck.filter_too_much])


@examples(400)
@given(st.integers(0, 10**9))
def test_a_file_as_an_enemy_would_write_it_reads_or_gives_a_data_error(tmp_path_factory, seed):
    path = Path(tmp_path_factory.getbasetemp()) / "fuzz.json"
    path.write_bytes(case(1, seed).data)
    doc = outcome(lambda: read_json(path))
    if isinstance(doc, DataError):
        assert str(doc).startswith("fuzz.json: ")
    else:
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
