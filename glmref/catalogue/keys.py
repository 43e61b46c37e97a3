"""Which keys a method file may have, and of what kind: the tables of ``glmref-method-1`` and 2."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from ..judge import claims as judged
from ..judge.claims import FORMATS, PAIRS, concerns, lacks_block
from ..judge.refusals import SIZE
from ..system.arguments import unknown_key
from .claims import CLAIMS, PlainClaims
from .strict_json import shown

__all__ = ["FORMATS", "PAIRS", "lacks_block"]

FORMAT = FORMATS[0]
#: What is read of the second format besides.
SECOND = frozenset(judged.SECOND_FORMAT)
MAX_SIZE = SIZE  # stages or values of one method
MAX_ORDER = 19  # the largest order one can claim: paths are compared up to 20, and one must fail
STATUS = ("as printed", "corrected", "derived", "regenerated")

_ENCLOSED = frozenset(["unknowns", "enclosure"])
#: Keys that the judge reads in certificates of a class, and no file has.
_JUDGED = {"splitting": {"starting"}, "partitioned-rk": {"starting", "separable"}}
#: Keys every class has.
COMMON = frozenset(judged.COMMON.split()) | _ENCLOSED
#: Keys of each class.
BLOCKS: Mapping[str, frozenset[str]] = {
    kind: frozenset(" ".join(keys).split()) - _ENCLOSED - _JUDGED.get(kind, set())
    for kind, keys in judged.CLASSES.items()
}
#: Keys of ``enclosure``.
ENCLOSURE = frozenset(["equations", "radius", "xi"])
#: Keys that are shown and not computed with, and what their values may be.
TEXTS: Mapping[str, tuple[type, ...]] = {"$schema": (str,), "title": (str,), "notes": (str, list)}
#: Keys of ``source``, and what their values may be.
SOURCE: Mapping[str, tuple[type, ...]] = {
    "citation": (str,),
    "where": (str,),
    "status": (str,),
    "doi": (str,),
    "bibtex": (str,),
    "errata": (list,),
    "notes": (str, list),
}


def bare(doc: Mapping[str, Any]) -> bool:
    """Return whether a document makes no claim, so that it need not say who made the method."""
    return doc.get("claims", {}) == {} and "broken" not in doc


def is_plain(document: Mapping[str, Any]) -> bool:
    """Return whether a document is in the plain dialect."""
    return "format" not in document and "broken" not in document


def name_of(text: str) -> str:
    """Return the name of a method that is made of the name of its file, or of any text."""
    return re.sub(r"[^a-z0-9.-]+", "-", text.lower()).lstrip(".-")[:100]


def completed(doc: Mapping[str, Any], where: str) -> dict[str, Any]:
    """Fill in what a tableau without claims, for which :func:`bare` holds, may leave out.

    That is ``format``, ``name`` (after its file), ``class``, ``claims`` and ``source``; ``class``
    is still missing where the keys do not tell it.
    """
    form = FORMATS[bool(doc.keys() & SECOND or str(doc.get("class")) in SECOND)]
    given = {
        "format": form,
        "name": name_of(where.removesuffix(".json")) or "unnamed",
        "claims": {},
        "source": {},
    }
    kind = class_of_keys(doc)
    if kind:
        given["class"] = kind
        given["format"] = FORMATS[1] if kind in SECOND else form
    return {**given, **doc}


def class_of_keys(doc: Mapping[str, Any]) -> str:
    """Return the class whose keys these are, ``""`` where no class has them.

    Where several classes fit, the one that uses the most keys is taken; ``alpha`` and ``beta``
    alone are a linear multistep method, with ``G`` they are a one-leg method.
    """
    keys = doc.keys() - COMMON
    fitting = [kind for kind in BLOCKS if needed_keys(kind) <= keys]
    return max(
        fitting, key=lambda kind: (len(keys & BLOCKS[kind]), len(needed_keys(kind))), default=""
    )


def needed_keys(kind: str) -> frozenset[str]:
    """Return keys of its blocks that a file of a class cannot leave out."""
    return frozenset(judged.CLASSES[kind][0].split())


def of_second(doc: Mapping[str, Any]) -> str:
    """Return what only the second format has and a document uses; ``""`` where it uses none."""
    kind = str(doc.get("class"))  # not yet known to be a text
    if kind in SECOND:
        return f"the class {kind!r}"
    new = () if kind == "pair-sweep" else sorted(doc.keys() & SECOND)
    return f"the key {new[0]!r}" if new else ""


#: Claims about one block of a file, which have no meaning for a class that cannot have it.
ABOUT: Mapping[str, str] = {claim: key for claim, (key, _) in judged.ABSENT.items()}


def without_meaning(kind: str) -> frozenset[str]:
    """Return the claims that a class cannot make.

    Those about one method for a pair, and the other way, and those about a block that it lacks.
    """
    return frozenset(x for x in CLAIMS if lacks_block(x, kind) or not concerns(x, kind))


def fault_of_texts(doc: Mapping[str, Any]) -> str:
    """Say what is wrong with the texts and objects that hold no numbers; ``""`` where all is well.

    The keys of the method document are known to be allowed.
    """
    for key, kinds in TEXTS.items():
        if key in doc and not _is_text(doc[key], kinds):
            return f"`{key}` must be a string, got {shown(doc[key])}"
    if not isinstance(doc.get("enclosure", {}), dict):
        return f"`enclosure` must be an object, got {shown(doc['enclosure'])}"
    enclosure = doc.get("enclosure", {})
    if fault := unknown_key(enclosure, sorted(ENCLOSURE), " in `enclosure`"):
        return fault
    equations = enclosure.get("equations", [])
    if not isinstance(equations, list) or not all(isinstance(x, str) for x in equations):
        return f"`enclosure.equations` must be a list of strings, got {shown(equations)}"
    if doc["source"] == {} and (bare(doc) or isinstance(doc["claims"], PlainClaims)):
        return ""
    return _fault_of_broken(doc) or _fault_of_source(doc["source"])


def _is_text(value: object, kinds: tuple[type, ...]) -> bool:
    """Return whether a value is a string, or a list of strings where lists are allowed."""
    if isinstance(value, list) and list in kinds:
        return all(isinstance(x, str) for x in value)
    return isinstance(value, str) and str in kinds


def _fault_of_broken(doc: Mapping[str, Any]) -> str:
    broken = doc.get("broken")
    if "broken" not in doc:
        return ""
    if (
        not isinstance(broken, dict)
        or not {"claim", "why"} <= broken.keys() <= {"claim", "why", "flag", "found"}
        or not all(isinstance(x, str) for x in broken.values())
    ):
        return (
            "`broken` must be an object with the strings claim, why, flag and found, "
            f"got {shown(broken)}"
        )
    return ""


def _fault_of_source(source: object) -> str:
    if not isinstance(source, dict):
        return f"`source` must be an object, got {shown(source)}"
    for key in ("citation", "where", "status"):
        if not isinstance(source.get(key), str) or not source[key].strip():
            return f"`source.{key}` must be a non-empty string; say who, where, how"
    if fault := unknown_key(source, SOURCE, " in `source`"):
        return fault
    for key, value in source.items():
        if not _is_text(value, SOURCE[key]):
            kind = "a list of sentences" if SOURCE[key] == (list,) else "a string"
            return f"`source.{key}` must be {kind}, got {shown(value)}"
    if source["status"] not in STATUS:
        return f"`source.status` must be one of {', '.join(STATUS)}, got {shown(source['status'])}"
    return ""
