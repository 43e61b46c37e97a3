"""Values that are no argument of any function, among them some that fail whatever is asked of them."""

import io
import math
from collections.abc import Callable
from decimal import Decimal
from itertools import count
from types import SimpleNamespace
from typing import Any

import mpmath
import numpy as np


class Hostile:
    """Fails whatever is asked of it."""

    def _fail(self, *_: object) -> Any:
        raise RuntimeError

    __repr__ = __str__ = __bool__ = __eq__ = __float__ = __index__ = __len__ = __iter__ = _fail
    __hash__ = None  # type: ignore[assignment]


class Long:
    def __repr__(self) -> str:
        return "one\n\x1b[31m" * 9999


#: No argument of any function is one of these.
ODD: dict[str, Callable[[], Any]] = {
    "hostile": Hostile,
    "long": Long,
    "text": lambda: "z\n" * 50_000,
    "surrogate": lambda: "\udcff",
    "bytes": lambda: b"rk4" * 1000,
    "object": object,
    "complex": lambda: np.complex64(1 + 1j),
    "complex array": lambda: np.array(1j),
    "masked": lambda: np.ma.masked,
    "duration": lambda: np.timedelta64(1, "s"),
    "record": lambda: np.zeros(2, dtype=[("a", "f8")]),
    "words": lambda: np.array(["rk4", "gauss-2"]),
    "cube": lambda: np.zeros((2, 2, 2)),
    "matrix": lambda: mpmath.matrix([[1, 2], [1, 4]]),
    "dict": lambda: {"a": 1},
    "nan": lambda: math.nan,
    "signal": lambda: Decimal("sNaN"),
    "endless": count,
    "namespace": lambda: SimpleNamespace(a=1),
    "tuple": lambda: ("enhanced",),
    "file": io.StringIO,
}
