"""From a method document to a method: every key and entry checked on the way.

The document is the JSON object of a file in the format ``glmref-method-1`` or ``glmref-method-2``;
``data/README.md`` is their contract. Each problem is a :class:`~glmref.errors.DataError` of one
sentence.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from typing import Any, cast

from ..errors import DataError, ExactnessError
from ..exact.expression import Text
from ..exact.linalg import Vector, diagonal
from ..method import (
    GLM,
    AdditiveGLM,
    FinishingMethod,
    Method,
    PairStartingMethod,
    PartitionedGLM,
    RosenbrockGLM,
    StartingMethod,
    families,
    nystrom,
    sweep,
)
from ..method.additive import MAX_PARTS
from ..method.embedded import EmbeddedRow
from ..method.preconsistency import output
from ..system.arguments import one_of, unknown_key
from .claims import SIZE, SOLUTION, PlainClaims
from .entries import Entries
from .files import document, names
from .keys import (
    ABOUT,
    BLOCKS,
    CLAIMS,
    COMMON,
    FORMAT,
    FORMATS,
    MAX_ORDER,
    MAX_SIZE,
    PAIRS,
    bare,
    completed,
    fault_of_texts,
    is_plain,
    lacks_block,
    needed_keys,
    of_second,
    without_meaning,
)
from .plain import normalised
from .strict_json import shown


def load_document(doc: Mapping[str, Any], *, where: str = "document") -> Method:
    """Turn a method document into a method, checking everything on the way.

    A document without ``format`` is in the plain dialect (:mod:`.plain`). One that makes no claims
    may leave out ``name``, ``class`` and ``source``; the class follows from the keys.

    Raises
    ------
    DataError
        For anything that is not as the format asks.
    """
    if isinstance(doc, Mapping) and is_plain(doc):
        try:
            doc, _ = normalised(doc, where)
        except DataError as error:
            raise DataError(f"{where}: {error}") from None
    elif isinstance(doc, Mapping) and bare(doc):
        doc = completed(doc, where)
    return _Reader(doc, where).method()


class _Reader(Entries):
    """Checks one document and builds its method."""

    def method(self) -> Method:
        if not isinstance(self.doc, Mapping):
            raise self.error(f"a method must be a JSON object, got {shown(self.doc)}")
        if self.doc.get("format") not in FORMATS:
            raise self.error(
                f"`format` must be {' or '.join(map(repr, FORMATS))}, got "
                f"{shown(self.doc.get('format'))}; this version reads no other"
            )
        if "class" not in self.doc:
            raise self.error(self._class_missing())
        kind = self.text("class")
        self._check_keys(one_of("class", kind, BLOCKS, self.error))
        new = of_second(self.doc) if self.doc["format"] == FORMAT else ""
        if new:
            raise self.error(f"{new} belongs to the format {FORMATS[1]!r}; say so in `format`")
        self.text("name", pattern=r"[a-z0-9][a-z0-9.-]{0,99}")
        fault = fault_of_texts(self.doc)
        if fault:
            raise self.error(fault)
        self.read_constants()
        build: Callable[[], Method] = getattr(self, "_" + kind.replace("-", "_"))
        try:
            built = build()
            for component in built.components:
                if component.output is not None:
                    output(component)  # refuses one that does not read the solution
            self._check_real(built)
        except DataError as error:
            prefix = f"{self.where}: "
            text = str(error)
            raise DataError(text if text.startswith(prefix) else prefix + text) from None
        except (ExactnessError, ZeroDivisionError) as error:
            raise self.error(f"the coefficients do not define a method ({error})") from None
        self.check_constants_used()
        return built

    def _class_missing(self) -> str:
        """Say that no class is named; of a bare tableau, that its keys do not tell it either."""
        text = f"the key `class` is missing; it is one of {', '.join(BLOCKS)}"
        if not bare(self.doc):
            return text
        return (
            f"{text}; the class follows from the keys, such as A, b or A, U, B, V or alpha, "
            f"beta, and not from {', '.join(sorted(self.doc.keys() - COMMON)) or 'none'}"
        )

    def _check_keys(self, kind: str) -> None:
        allowed = COMMON | BLOCKS[kind]
        if fault := unknown_key(self.doc, sorted(allowed), f" for class {kind!r}"):
            raise self.error(fault)
        for key in ("name", "claims", "source", *sorted(needed_keys(kind))):
            if key not in self.doc:
                raise self.error(f"the key {key!r} is missing; a file of class {kind!r} needs it")

    def _forms(self, r: int) -> dict[str, Any]:
        """Read the optional G and D. G may be given by its diagonal."""
        forms: dict[str, Any] = {}
        if "G" in self.doc:
            rows = self.doc["G"]
            if isinstance(rows, list) and rows and all(isinstance(x, str) for x in rows):
                forms["G"] = diagonal(self.vector(rows, "G"))
            else:
                forms["G"] = self.matrix(rows, "G")
        for key in ("D", "D_P", "D_Q"):
            if key in self.doc:
                forms[key] = self.vector(self.doc[key], key)
        return forms

    def _common(self) -> dict[str, Any]:
        """Return what every class shares: name, claims, source, the document."""
        shared = {"name": self.doc["name"], "claims": self._claims(), "document": self.doc}
        return {**shared, "source": dict(self.doc["source"])}

    def _record(self, r: int) -> dict[str, Any]:
        """Return what methods of one component share."""
        blocks = {"starting": self._starting(r), "finishing": self._finishing()}
        return {**self._common(), **blocks}

    def _one_step(self, base: GLM) -> GLM:
        return replace(base, **self._record(base.r))

    def _glm(self) -> GLM:
        blocks = self.square(self.doc, "AUBV")
        r = len(blocks["V"])
        declared = self._output(self.doc, "", "output")
        embedded = tuple(
            EmbeddedRow(
                name,
                (self.vector(row["b"], f"{where}.b"),),
                values=self.vector(row["v"], f"{where}.v"),
            )
            for name, row, where in self._rows("b", "v", together=True)
        )
        return GLM(**blocks, **self._forms(r), **self._record(r), **declared, embedded=embedded)

    def _output(self, block: Mapping[str, Any], where: str, name: str) -> dict[str, Any]:
        """Read the optional functional that says where the solution is among the values."""
        return {name: self.vector(block["output"], f"{where}output")} if "output" in block else {}

    def _rk(self) -> GLM:
        base = families.runge_kutta(
            self.matrix(self.doc["A"], "A"), self.vector(self.doc["b"], "b")
        )
        more: dict[str, Any] = {
            "embedded": tuple(
                EmbeddedRow(name, (self.vector(row[key], f"{where}.{key}"),), key == "error")
                for name, row, where in self._rows("b", "error")
                for key in ("b", "error")
                if key in row
            )
        }
        if "c" in self.doc:
            more["abscissae_given"] = self.vector(self.doc["c"], "c")
        if "dense" in self.doc:
            more["dense"] = self.matrix(self.doc["dense"], "dense")
        return self._one_step(replace(base, **more))

    def _rows(self, *keys: str, together: bool = False) -> Iterator[tuple[str, Any, str]]:
        """Name, object and place of each row of ``embedded``, which has one of some keys, or all.

        Raises
        ------
        DataError
            For another shape.
        """
        rows, names = self.doc.get("embedded", []), set()
        if not isinstance(rows, list) or ("embedded" in self.doc and not rows):
            raise self.error(f"`embedded` must be a list of rows, got {shown(rows)}")
        for n, row in enumerate(rows, 1):
            where = f"embedded[{n}]"
            if not isinstance(row, dict) or not isinstance(row.get("name"), str):
                raise self.error(f"`{where}` must be an object with the string `name`")
            given = row.keys() - {"name"}
            if given != set(keys) if together else len(given) != 1 or not given <= set(keys):
                word = " and " if together else " or "
                wanted = word.join(f"`{x}`" for x in keys)
                raise self.error(f"`{where}` must have `name` and {wanted}, and nothing else")
            if row["name"] == SOLUTION:
                raise self.error(
                    f"`{where}` is called {shown(SOLUTION)}, as the weights of the solution are; "
                    f"give the row another name"
                )
            if row["name"] in names:
                raise self.error(f"`embedded` has the name {shown(row['name'])} twice")
            names.add(row["name"])
            yield row["name"], row, where

    def _nystrom(self) -> PartitionedGLM:
        doc = self.doc
        rows = [
            (
                name,
                self.vector(row["b"], f"{where}.b"),
                self.vector(row["b_prime"], f"{where}.b_prime"),
            )
            for name, row, where in self._rows("b", "b_prime", together=True)
        ]
        built = nystrom(
            self.matrix(doc["A"], "A"),
            self.vector(doc["b"], "b"),
            self.vector(doc["b_prime"], "b_prime"),
            self.vector(doc["c"], "c"),
            self.matrix(doc["A_prime"], "A_prime") if "A_prime" in doc else None,
            rows,
        )
        return self._pair(built)

    def _rosenbrock(self) -> RosenbrockGLM:
        rows = tuple(
            (name, self.vector(row["b"], f"{where}.b")) for name, row, where in self._rows("b")
        )
        return RosenbrockGLM.of(
            self.matrix(self.doc["alpha"], "alpha"),
            self.matrix(self.doc["gamma"], "gamma"),
            self.vector(self.doc["b"], "b"),
            rows,
            **self._common(),
        )

    def _sweep(self) -> GLM:
        D, blocks = self.vector(self.doc["D"], "D"), self.square(self.doc, "XVG")
        explicit = sweep.explicit_stages(self.doc.get("enclosure", {}), len(D))
        return self._one_step(sweep.build(D, **blocks, explicit=explicit))

    def _pair_sweep(self) -> PartitionedGLM:
        rows = {x: self.matrix(self.doc[x], x) for x in ("w", "v") if x in self.doc}
        blocks = self.square(self.doc, ("V", "V_hat"))
        built = sweep.build_partitioned(
            self.vector(self.doc["b"], "b"),
            self.vector(self.doc["c"], "c"),
            **rows,
            **blocks,
            G=self._forms(0)["G"],
            stages=self.text("stages", pattern=r"[PQ]+"),
        )
        return self._pair(built)

    def _lmm(self) -> GLM:
        coefficients = self._alpha_beta()
        return self._one_step(families.linear_multistep(*coefficients))

    def _one_leg(self) -> GLM:
        coefficients = self._alpha_beta()
        if (sum(coefficients[1][1:], coefficients[1][0]) - 1).is_zero() is False:
            raise self.error("`beta` of a one-leg method must sum to 1")
        built = families.one_leg(*coefficients)
        return replace(
            built, **self._forms(built.r), **self._record(built.r), multistep=coefficients
        )

    def _alpha_beta(self) -> tuple[Vector, Vector]:
        alpha = self.vector(self.doc["alpha"], "alpha")
        beta = self.vector(self.doc["beta"], "beta")
        if len(alpha) != len(beta):
            raise self.error(
                f"`alpha` and `beta` must have the same length, got {len(alpha)} and {len(beta)}"
            )
        return alpha, beta

    def _composition(self) -> GLM:
        name = self.text("base")
        if name not in names("methods"):  # never a path: a file stands for itself
            raise self.error(f"`base` must be the name of a shipped method, got {shown(name)}")
        base = document(name)
        if base.get("class") != "rk":
            raise self.error(f"`base` must name a method of class 'rk', got {self.doc['base']!r}")
        built = cast("GLM", load_document(base, where=f"{name}.json"))  # it is of class 'rk'
        return self._one_step(families.composition(built, self.vector(self.doc["gamma"], "gamma")))

    def _splitting(self) -> PartitionedGLM:
        first = self.text("first", pattern="q|p")
        built = families.splitting(
            self.vector(self.doc["a"], "a"), self.vector(self.doc["b"], "b"), first=first
        )
        return self._pair(built)

    def _partitioned_rk(self) -> PartitionedGLM:
        built = families.partitioned_runge_kutta(
            self.matrix(self.doc["A"], "A"),
            self.vector(self.doc["b"], "b"),
            self.matrix(self.doc["A_hat"], "A_hat"),
            self.vector(self.doc["b_hat"], "b_hat"),
        )
        return self._pair(built)

    def _additive(self) -> AdditiveGLM:
        parts = self.doc["parts"]
        if not isinstance(parts, list) or not all(isinstance(x, dict) for x in parts):
            raise self.error("`parts` must be a list of objects with A and b")
        if not 2 <= len(parts) <= MAX_PARTS:
            raise self.error(f"`parts` must be 2 to {MAX_PARTS} tableaux, got {len(parts)}")
        A, B = [], []
        for n, part in enumerate(parts, 1):
            if set(part) != {"A", "b"}:
                raise self.error(f"`parts[{n}]` must have the keys A and b, and no others")
            A.append(self.matrix(part["A"], f"parts[{n}].A"))
            B.append((self.vector(part["b"], f"parts[{n}].b"),))
        embedded = []
        for name, row, where in self._rows("b"):
            weights = self.matrix(row["b"], f"{where}.b")
            if len(weights) != len(parts):
                raise self.error(f"`{where}.b` must have {len(parts)} rows, got {len(weights)}")
            embedded.append(EmbeddedRow(name, weights))
        return AdditiveGLM(A, B, **self._common(), embedded=tuple(embedded))

    def _partitioned(self) -> PartitionedGLM:
        for key in ("q", "p"):
            if not isinstance(self.doc[key], dict):
                raise self.error(f"`{key}` must be an object with A, U, B and V")
        q = self.square(self.doc["q"], "AUBV", "q.")
        p = {f"{x}_hat": y for x, y in self.square(self.doc["p"], "AUBV", "p.").items()}
        declared = self._output(self.doc["q"], "q.", "output")
        declared |= self._output(self.doc["p"], "p.", "output_hat")
        separable = self.doc.get("separable", False)
        if not isinstance(separable, bool):
            raise self.error(f"`separable` must be true or false, got {shown(separable)}")
        forms = self._forms(len(q["V"]))
        built = PartitionedGLM(**q, **p, **forms, **declared, separable=separable)
        return self._pair(built)

    def _pair(self, built: PartitionedGLM) -> PartitionedGLM:
        return replace(built, starting=self._pair_starting(built), **self._common())

    def _pair_starting(self, pair: PartitionedGLM) -> PairStartingMethod | None:
        m = self._tableau_block("starting", "A B A_hat B_hat", "u u_hat")
        if m is None:
            return None
        n_q, n_p = len(m["A"]), len(m["A_hat"])
        wanted = {"A": (n_q, n_p), "A_hat": (n_p, n_q)}
        wanted |= {"B": (pair.r, n_p), "B_hat": (pair.r_hat, n_q)}
        for x, shape in wanted.items():
            if (len(m[x]), len(m[x][0])) != shape:
                raise self.error(
                    f"`starting.{x}` must have shape {shape} for {n_q} rows of `starting.A`, {n_p} "
                    f"rows of `starting.A_hat`, r = {pair.r} and r^ = {pair.r_hat}, got "
                    f"({len(m[x])}, {len(m[x][0])})"
                )
        for x, r in (("u", pair.r), ("u_hat", pair.r_hat)):
            if len(m[x]) != r:
                raise self.error(
                    f"`starting.{x}` must have {r} entries, one for each value, got {len(m[x])}"
                )
        if n_q != n_p and not pair.separable:
            raise self.error(
                f"`starting` must have as many stages Q as stages P, which are evaluated together "
                f"where the pair is not separable, got {n_q} and {n_p}"
            )
        return PairStartingMethod(**m)

    def _starting(self, r: int) -> StartingMethod | None:
        m = self._tableau_block("starting", "A B", "u")
        if m is None:
            return None
        A, B, u = m["A"], m["B"], m["u"]
        shapes = {len(A), len(A[0]), len(B[0])}
        if len(shapes) > 1 or len(B) != r or len(u) != r:
            raise self.error(
                f"`starting` must have A (m, m), B (r, m) and u (r) with r = {r}, got "
                f"A ({len(A)}, {len(A[0])}), B ({len(B)}, {len(B[0])}) and u ({len(u)})"
            )
        return StartingMethod(**m)

    def _finishing(self) -> FinishingMethod | None:
        m = self._tableau_block("finishing", "A", "b")
        if m is None:
            return None
        A, b = m["A"], m["b"]
        if not len(A) == len(A[0]) == len(b):
            raise self.error(
                f"`finishing` must have A (m, m) and b (m), got A ({len(A)}, {len(A[0])}) and "
                f"b ({len(b)})"
            )
        return FinishingMethod(**m)

    def _tableau_block(self, key: str, matrices: str, vectors: str) -> dict[str, Any] | None:
        """Read a start or a finish: fields of its class by name."""
        block = self.doc.get(key)
        if block is None:
            return None
        needed = (*matrices.split(), *vectors.split())
        if not isinstance(block, dict):
            raise self.error(f"`{key}` must be an object with {', '.join(needed)}")
        if fault := unknown_key(block, (*needed, "order", "name", "kind"), f" in `{key}`"):
            raise self.error(fault)
        for name in needed:
            if name not in block:
                raise self.error(f"`{key}.{name}` is missing")
        if block.get("kind", "runge-kutta") != "runge-kutta":
            raise self.error(f"`{key}.kind` must be 'runge-kutta', got {shown(block['kind'])}")
        if "order" in block:
            self._whole_number(block["order"], f"`{key}.order`")
        return {
            **{x: self.matrix(block[x], f"{key}.{x}") for x in matrices.split()},
            **{x: self.vector(block[x], f"{key}.{x}") for x in vectors.split()},
            "name": str(block.get("name", "")),
            "claims": {x: block[x] for x in ("order",) if x in block},
        }

    def _whole_number(self, value: object, what: str) -> None:
        if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value <= MAX_ORDER:
            raise self.error(
                f"{what} must be a whole number from 0 to {MAX_ORDER}, got {shown(value)}"
            )

    def _claims(self) -> Mapping[str, Any]:
        claims = self.doc["claims"]
        if not isinstance(claims, dict):
            raise self.error(f"`claims` must be an object of claims, got {shown(claims)}")
        if fault := unknown_key(claims, sorted(CLAIMS), kind="claim"):
            raise self.error(fault)
        for key, value in claims.items():
            if key in without_meaning(self.doc["class"]):
                kind = "a pair" if self.doc["class"] in PAIRS else "one method"
                own = {"additive": "an additive method", "rosenbrock": "a Rosenbrock method"}
                kind = own.get(self.doc["class"], kind)
                if lacks_block(key, self.doc["class"]):
                    kind = f"class {self.doc['class']!r}, which has no `{ABOUT[key]}`"
                raise self.error(f"the claim {key!r} has no meaning for {kind}; take it out")
            wanted = CLAIMS[key].type
            if wanted is int:
                self._whole_number(value, f"the claim {key!r}")
            elif wanted is dict and isinstance(value, dict):
                for name, order in value.items():
                    what = f"the claim {key!r} of {shown(name)}"
                    if CLAIMS[key].sized:
                        rows = self.doc.get("embedded", [])
                        known = [SOLUTION, *(x["name"] for x in rows)]
                        if name not in known:
                            raise self.error(
                                f"the claim {key!r} names {shown(name)}, and the weights are "
                                f"{', '.join(known)}"
                            )
                        if not (isinstance(order, list) and len(order) == 2):
                            wanted_as = '[10, "2.7e-85"], an order and the size of a residual'
                            raise self.error(f"{what} must be {wanted_as}, got {shown(order)}")
                        order, size = order
                        if not isinstance(size, str) or not SIZE.fullmatch(size):
                            raise self.error(
                                f"{what} has the residual {shown(size)}; write two digits and a "
                                f'power of ten, such as "2.7e-85"'
                            )
                    self._whole_number(order, what)
            elif not isinstance(value, wanted):
                kinds = {bool: "true or false", list: "a list of strings", dict: "orders by name"}
                kind = kinds.get(wanted, "a string")
                raise self.error(f"the claim {key!r} must be {kind}, got {shown(value)}")
        found = {key: self._claimed(value, f"claims.{key}") for key, value in claims.items()}
        if not isinstance(claims, PlainClaims):
            return found
        plain = PlainClaims(found)
        plain.said, plain.name = claims.said, claims.name
        if claims.times is not None:
            plain.times = tuple(x and self.vector(x, "c") for x in claims.times)
        return plain

    def _claimed(self, value: Any, where: str) -> Any:
        """Attach their values to the expressions of a claim."""
        if isinstance(value, bool | int | dict):
            return value
        if isinstance(value, list):
            if len(value) > MAX_SIZE:
                raise self.error(f"`{where}` has {len(value)} entries and at most {MAX_SIZE}")
            pairs = [(text, self.scalar(text, f"{where}[{i + 1}]")) for i, text in enumerate(value)]
            return [Text(text, number) for text, number in pairs]
        return Text(value, self.scalar(value, where))

    def _check_real(self, built: Method) -> None:
        """Refuse complex entries in a tableau that does not say ``"field": "complex"``."""
        field = self.doc.get("field", "real")
        if one_of("field", field, ("real", "complex"), self.error) == "complex":
            return
        blocks: dict[str, Any] = {}
        for n, c in enumerate(built.components, 1):
            hat = f"^{n}" if built.additive else built.LETTERS[c.colour]
            blocks |= {x + hat: getattr(c, x) for x in "AUBV"}
        names = ("G", "D", "D_P", "D_Q", "output", "output_hat")
        blocks |= {x: getattr(built, x, None) for x in names}
        for letter, block in blocks.items():
            for i, row in enumerate(block or ()):
                for j, x in enumerate(row if isinstance(row, tuple) else (row,)):
                    if not x.is_real():
                        place = f"[{i + 1}][{j + 1}]" if isinstance(row, tuple) else f"[{i + 1}]"
                        raise self.error(
                            f"{self._entry_named(letter, place)} is complex ({complex(x):.6g}) in "
                            f"a real tableau; a square root of a negative number, or say "
                            f'"field": "complex"'
                        )

    def _entry_named(self, letter: str, place: str) -> str:
        """Name an entry as the file writes it; it may have b or other numbers for B."""
        if letter in self.doc or letter in ("A_hat", "D", "D_P", "D_Q"):
            return f"`{letter}{place}`"
        weights = letter.replace("B", "b")
        if weights in self.doc and self.doc["class"] in ("rk", "partitioned-rk"):
            return f"`{weights}{place.removeprefix('[1]')}`"
        return f"the entry {letter}{place} of the general linear form"
