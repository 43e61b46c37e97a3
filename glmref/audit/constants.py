"""Numbers that a tree gives names, for the files in which such a name stands without one.

As those of a header: ``#define LAMBDA 0.193``, ``static const double theta = 1.35;``, and of
members of a class that begin with one of them, ``: m_lambda(LAMBDA)``. A name with two values has
none.
"""

from __future__ import annotations

import re
from collections.abc import Mapping

#: A number with digits that say something, maybe in a call: ``(F(0.19))``; or a quotient.
_VALUE = (
    r"\(?\s*(?:\w{1,12}\(\s*)?"
    r"([-+]?\s*(?:\d*\.\d{5,}(?:[eEdD][-+]?\d+)?|\d+\.?\s*/\s*\d+\.))\w*\s*\)?\s*\)?"
)
_DEFINED = re.compile(
    rf"^[ \t]*#[ \t]*define[ \t]+(\w+)[ \t]+{_VALUE}[ \t]*(?://.*|/\*.*)?$"
    rf"|\b(?:const|constexpr|parameter|final|static)\b[^;\n={{}}()]*?\b(\w+)\s*=\s*{_VALUE}\s*[;,\n]",
    re.MULTILINE,
)
_LONG = re.compile(r"\.\d{5}|\d/\d")
_MEMBER = re.compile(r"[:,]\s*(\w+)\(\s*(\w+)\s*\)\s*(?=[,{\n])")


_WORDS = ("const", "define", "parameter", "final", "static")


def may_hold_constants(text: str) -> bool:
    """Return whether a text has a number of many digits, or names of them, at a word for it."""
    return any(x in text for x in _WORDS) and (_LONG.search(text) is not None or "m_" in text)


def constants_of(texts: Mapping[str, str]) -> dict[str, str]:
    """Return the numbers of the names of a tree, as they are written, with ``@path:line``.

    Parameters
    ----------
    texts : Mapping of str to str
        Its sources by their paths.
    """
    found: dict[str, dict[str, str]] = {}
    members: dict[str, set[str]] = {}
    for path, text in texts.items():
        for m in _DEFINED.finditer(text):
            value = (m[2] or m[4]).replace(" ", "")
            place = f"{path}:{text.count(chr(10), 0, m.start(2) if m[2] else m.start(4)) + 1}"
            found.setdefault(m[1] or m[3], {}).setdefault(value, place)
        for name, value in _MEMBER.findall(text) if "(" in text else ():
            members.setdefault(name, set()).add(value)
    single = {name: "@".join(*values.items()) for name, values in found.items() if len(values) == 1}
    for name, given in members.items():
        held = {single.get(x, "") for x in given}
        if len(held) == 1 and "" not in held and name not in found:
            single[name] = held.pop()
    return single
