"""What to look for: stages, values, symmetry, what is fixed; turned into a document to be solved.

An ansatz is a symmetric, diagonally implicit, G-symplectic method in the sweep form
(:mod:`glmref.method.sweep`) with V = diag(1, blocks), each block a complex pair on the unit circle
or -1:

    D        palindromic                                       b1, b2, ..
    X        row of ones
             for a complex pair: Re omega antisymmetric        alpha1, ..   (then delta1, ..)
                                 Im omega symmetric            beta1, ..    (then eta1, ..)
             for -1: symmetric or antisymmetric                gamma1, ..   (then kappa1, ..)
    G        1, then a sign for each row

The rotation of a pair stands as [[Re z, -Im z], [Im z, Re z]]; the phase of omega is normalised
so that reversing the stages maps omega to -conj omega.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ..catalogue.strict_toml import loads
from ..errors import DataError, UsageError
from ..exact import Exact
from ..exact.expression import parse
from ..prove.equations import free_trees, representatives
from ..system.arguments import unknown_key
from ..system.files import read_text
from .recognise import exact_text

MAX_BYTES = 200_000

_PAIR_NAMES = (("alpha", "beta"), ("delta", "eta"), ("phi", "psi"))
_REAL_NAMES = ("gamma", "kappa", "lambda")


def mirrored(name: str, size: int, parity: int) -> list[str]:
    """Return a row ``name1``, ``name2``, .. equal to its mirror image up to the sign ``parity``."""
    half = [f"{name}{i + 1}" for i in range(size // 2)]
    middle = [f"{name}{size // 2 + 1}" if parity > 0 else "0"] * (size % 2)
    return half + middle + [x if parity > 0 else f"-{x}" for x in reversed(half)]


def remainder(name: str, row: Sequence[str]) -> str:
    """Return the entry ``name`` from the condition that the row sums to 1."""
    others = [(x, row.count(x)) for x in dict.fromkeys(row) if x != name]
    total = "1" + "".join(f"-{x}" if k == 1 else f"-{k}*{x}" for x, k in others)
    return total if row.count(name) == 1 else f"({total})/{row.count(name)}"


@dataclass(frozen=True)
class Value:
    """One eigenvalue of V other than 1: a complex pair (two values) or -1."""

    eigenvalue: str  #: Expression on the unit circle, such as ``"exp(2*pi*i/3)"`` or ``"-1"``.
    sign: int = -1  #: +1 or -1, its entry in G.
    parity: int = 1  #: Of its row of X under stage reversal; only for -1.

    @property
    def is_pair(self) -> bool:
        """Whether it stands for a complex pair."""
        return not parse(self.eigenvalue).is_real()


@dataclass(frozen=True)
class Ansatz:
    """An ansatz; :meth:`document` states it as a method document without digits."""

    name: str  #: Name of the method to be.
    stages: int  #: s.
    order: int = 6  #: even.
    #: Eigenvalues of V besides 1.
    values: Sequence[Value] = (Value("exp(2*pi*i/3)"), Value("-1", 1))
    #: Exact expressions for some of the unknowns.
    fixed: Mapping[str, str] = field(default_factory=dict)
    stage_order: int = 1  #: q; every stage then satisfies eta(t) = c^|t| / gamma(t) for |t| <= q.
    #: Stages (from 1, one of each mirror pair) that need no equation solved.
    explicit: Sequence[int] = ()
    abscissae: Mapping[int, str] = field(default_factory=dict)  #: Stage -> exact abscissa.
    parasitism_free: bool = True  #: Whether the growth parameters are to vanish.
    equations: Sequence[str] | None = None  #: The equations, where the usual ones are not wanted.
    #: Whether the principal start is free (a conjugation) where the order allows it.
    xi: bool = True
    title: str = ""  #: One line for the file.

    def __post_init__(self) -> None:
        if not 1 <= self.stages <= 12:
            raise UsageError(f"`stages` must lie between 1 and 12, got {self.stages}")
        if self.order not in (2, 4, 6, 8, 10):
            raise UsageError(f"`order` must be 2, 4, 6, 8 or 10, got {self.order}")
        for value in self.values:
            z = parse(value.eigenvalue)
            if not isinstance(z, Exact) or z * z.conjugate() != 1 or z == 1:
                raise UsageError(
                    f"an eigenvalue must lie on the unit circle and not be 1, "
                    f"got {value.eigenvalue!r}"
                )

    @classmethod
    def from_toml(cls, path: Path) -> Ansatz:
        """Read an ansatz from a TOML file with the attributes of this class as keys.

        ``values`` is an array of tables with ``eigenvalue``, ``sign`` and ``parity``.

        Raises
        ------
        DataError
            For an unknown key or a file that is not TOML.
        """
        try:
            table = loads(read_text(path, MAX_BYTES))
        except DataError as error:
            raise DataError(f"the ansatz {str(path)!r} cannot be read ({error})") from None
        except (ValueError, RecursionError) as error:
            raise DataError(f"{path.name}: the ansatz is not TOML ({error})") from None
        return cls.from_table(table, path.name)

    @classmethod
    def from_table(cls, given: Mapping[str, Any], name: str) -> Ansatz:
        """Read an ansatz from a table with the attributes of this class as keys.

        Raises
        ------
        DataError
            For an unknown key or a wrong value; the sentence begins with the name.
        """
        table = dict(given)
        if fault := unknown_key(table, cls.__dataclass_fields__, " in an ansatz"):
            raise DataError(f"{name}: {fault}")
        try:
            if "values" in table:
                table["values"] = [Value(**x) for x in table["values"]]
            table["abscissae"] = {int(k): str(v) for k, v in table.get("abscissae", {}).items()}
            table["fixed"] = {k: str(v) for k, v in table.get("fixed", {}).items()}
            return cls(**table)
        except (TypeError, ValueError) as error:
            raise DataError(f"{name}: the ansatz is not complete ({error})") from None

    def _row(self, name: str, parity: int) -> list[str]:
        return mirrored(name, self.stages, parity)

    def _rows(self) -> tuple[list[list[str]], list[int], list[list[str]]]:
        """Return X, the diagonal of G, and V, row by row."""
        X, G, blocks = [["1"] * self.stages], [1], [[["1"]]]
        pairs, reals = iter(_PAIR_NAMES), iter(_REAL_NAMES)
        for value in self.values:
            z = parse(value.eigenvalue)
            assert isinstance(z, Exact)
            if value.is_pair:
                first, second = next(pairs)
                X += [self._row(first, -1), self._row(second, 1)]
                G += [value.sign, value.sign]
                c, s = exact_text(z.real), exact_text(z.imag)
                blocks.append([[c, exact_text(-z.imag)], [s, c]])
            else:
                X.append(self._row(next(reals), value.parity))
                G.append(value.sign)
                blocks.append([["-1"]])
        return X, G, _block_diagonal(blocks)

    def _equations(self) -> list[str]:
        if self.equations is not None:
            return list(self.equations)
        result = [
            f"defect {i + 1}" + ("" if n == 2 else f" [{'o' * (n - 1)}]")
            for n in range(2, self.stage_order + 1)
            for i in range((self.stages + 1 - n % 2) // 2)
        ]
        for n in range(3, self.order, 2):
            result += [f"order {t}" for t in representatives(n, self.stage_order)]
        if self.parasitism_free:
            result += [f"growth {value.eigenvalue}" for value in self.values]
        result += [f"explicit {i}" for i in self.explicit]
        return result + [f"abscissa {i} = {x}" for i, x in self.abscissae.items()]

    def _principal(self) -> dict[str, str]:
        if not self.xi:
            return {}
        free = [t for n in range(4, self.order, 2) for t in free_trees(n, self.stage_order)]
        return {t: "xi" if k == 0 else f"xi{k + 1}" for k, t in enumerate(free)}

    def document(self) -> dict[str, Any]:
        """Return the method document: entries, unknowns (their values empty), equations.

        The last of b1, b2, .. that is not fixed follows from sum d_i = 1.

        Raises
        ------
        UsageError
            When a fixed name is not in the ansatz.
        """
        X, G, V = self._rows()
        D, principal = self._row("b", 1), self._principal()
        names = list(dict.fromkeys(x for row in (D, *X) for x in row if x[0].isalpha()))
        names += principal.values()
        for name in self.fixed:
            if name not in names:
                raise UsageError(f"`fixed` names {name!r}, and the ansatz has {', '.join(names)}")
        free_b = [x for x in dict.fromkeys(D) if x not in self.fixed]
        constants = dict(self.fixed)
        if free_b:
            constants[free_b[-1]] = remainder(free_b[-1], D)
        unknowns = {x: "" for x in names if x not in constants}
        return {
            "format": "glmref-method-1",
            "name": self.name,
            "title": self.title,
            "class": "sweep",
            "constants": constants,
            "unknowns": unknowns,
            "D": D,
            "X": X,
            "V": V,
            "G": [["1" if i == j and g > 0 else "-1" if i == j else "0" for j in range(len(G))]
                  for i, g in enumerate(G)],
            "enclosure": {"equations": self._equations(), "radius": "1e-60", "xi": principal},
            "claims": {"order": self.order},
        }  # fmt: skip


def _block_diagonal(blocks: Sequence[Sequence[Sequence[str]]]) -> list[list[str]]:
    size, left, rows = sum(len(b) for b in blocks), 0, []
    for block in blocks:
        for row in block:
            rows.append(["0"] * left + list(row) + ["0"] * (size - left - len(row)))
        left += len(block)
    return rows
