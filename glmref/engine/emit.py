"""Where generated statements live: local variables, an array over components, or lanes.

A statement such as ``@Y = @z + @L`` is written once and holds for every component. The targets
below turn it into source:

* :class:`ScalarTarget` one line per component on local variables ``Y_0``, ``Y_1`` ... (small
  systems: everything stays in registers);
* :class:`ArrayTarget` one loop over components of a work array (large systems: the source, and so
  the time to compile, does not grow with the dimension);
* :class:`LaneTarget` one line per component inside a loop over lanes, each lane one trajectory
  (ensembles: the loop over lanes becomes SIMD instructions);
* :class:`VectorTarget` the loops of an array, where each entry is a vector of lanes (ensembles of
  large systems).

Each evaluates in the order of the one for single trajectories, so they give the same bits.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import pairwise

from .shape import Part, Shape, inlined, parameter_names, used_parameters
from .unroll import placed

#: Infinity as generated source has it: a literal beyond the range of doubles. A state is finite
#: below it, in generated steps as in those of the reference.
INFINITE = "1e999"

_REFERENCE = re.compile(r"@(\w+)")
_COUNTER = re.compile(r"\bcomponent\b")


class Writer:
    """Lines of source with indentation."""

    def __init__(self) -> None:
        self.lines: list[str] = []
        self.depth = 0

    def __call__(self, *lines: str) -> None:
        """Write lines at the current depth."""
        self.lines += ["    " * self.depth + line if line else "" for line in lines]

    @contextmanager
    def block(self, head: str) -> Iterator[None]:
        """Write ``head`` and indent what follows."""
        self(head)
        self.depth += 1
        yield
        self.depth -= 1

    @property
    def text(self) -> str:
        """The source so far."""
        return "\n".join(self.lines) + "\n"


def length_check(part: Part) -> tuple[str, str]:
    """Write lines that refuse a result of another length, which compiled code would read beyond."""
    size = part.stop - part.start
    says = f"it must return {size} numbers and returned another number of them"
    return f"if len(found) != {size}:", f"    raise IndexError({says!r})"


def tree_sum(terms: Sequence[str]) -> str:
    """Write a sum by halves: short dependency chains, and one order for every target."""
    if len(terms) == 1:
        return terms[0]
    half = (len(terms) + 1) // 2
    return f"({tree_sum(terms[:half])} + {tree_sum(terms[half:])})"


class Target:
    """Common part: names, right-hand sides and where the state is kept between calls."""

    #: Whether statements stand in a loop over lanes, and how often the work array has each number.
    looped, width = False, 1

    def __init__(self, shape: Shape, writer: Writer) -> None:
        self.shape, self.w = shape, writer
        self.d = shape.dimension
        #: Of a loop over lanes: vectors, and components of them, that live in one pass over them.
        self.local: dict[str, range] = {}
        self.places: dict[str, int] = {}
        self.used = 0
        self.loops = 0

    def reserve(self, name: str, length: int) -> int:
        """Return the place of an array in the work array ``x``, the same for the same name."""
        if name not in self.places:
            self.places[name] = self.used
            self.used += length
        return self.places[name]

    def offset(self, name: str) -> int:
        """Return the place of a vector in the work array."""
        return self.reserve(name, self.d * self.width)

    @property
    def work_size(self) -> int:
        """Length of the work array."""
        return max(1, self.used)

    def load(self, names: Sequence[str]) -> None:
        """Read vectors of the state, kept at the head of ``x``, at the beginning of a call."""

    def store(self, names: Sequence[str]) -> None:
        """Write them back at its end."""

    def ref(self, name: str, c: int) -> str:
        """Return the source of component c of a vector."""
        raise NotImplementedError

    def vec(self, lines: Sequence[str], part: tuple[int, int] | None = None) -> None:
        """Write statements for every component of ``part`` (all of them by default)."""
        raise NotImplementedError

    def total(self, name: str, template: str, part: tuple[int, int] | None = None) -> None:
        """Assign to ``name`` the sum of ``template`` over components."""
        raise NotImplementedError

    def call(self, part: Part, source: str, out: str, tag: str) -> None:
        """Evaluate a part of the right-hand side at vector ``source`` into ``out``."""
        raise NotImplementedError

    def substitute(self, line: str, c: int) -> str:
        """Replace the references of a statement for component c."""
        return _REFERENCE.sub(lambda match: self.ref(match[1], c), line)

    def parameters(self) -> None:
        """Load the parameters that expressions use into local variables."""
        for i in used_parameters(self.shape):
            self.w(f"par_{self.shape.parameters[i]} = par[{i}]")

    def inline(self, part: Part, source: str, out: str, tag: str) -> None:
        """Write the expressions or straight lines of a part, component by component."""
        if part.formula is None:
            first = len(self.shape.parameters)
            lines = placed(
                part.straight, lambda i: self.ref(source, part.source + i),
                lambda i: self.ref(out, part.start + i), lambda i: f"par[{first + i}]", f"{tag}_",
            )  # fmt: skip
            self.w(*lines)
            return
        lines, outputs = inlined(
            part.formula,
            lambda i: self.ref(source, part.source + i),
            parameter_names(self.shape),
            f"{tag}_",
        )
        self.w(*lines)
        for c, text in zip(range(part.start, part.stop), outputs, strict=True):
            self.w(f"{self.ref(out, c)} = {text}")

    def identity(self, part: Part, source: str, out: str) -> None:
        """Copy: q' = p."""
        for c in range(part.start, part.stop):
            self.w(f"{self.ref(out, c)} = {self.ref(source, part.source + c - part.start)}")


class _Unrolled(Target):
    """One line of source for each component."""

    def vec(self, lines: Sequence[str], part: tuple[int, int] | None = None) -> None:
        """See :class:`Target`."""
        for c in range(*(part or (0, self.d))):
            self.w(*(self.substitute(line, c) for line in lines))

    def total(self, name: str, template: str, part: tuple[int, int] | None = None) -> None:
        """See :class:`Target`."""
        terms = [self.substitute(template, c) for c in range(*(part or (0, self.d)))]
        self.w(f"{name} = {tree_sum(terms)}")


class ScalarTarget(_Unrolled):
    """Components are local variables."""

    def ref(self, name: str, c: int) -> str:
        """See :class:`Target`."""
        return f"{name}_{c}"

    def call(self, part: Part, source: str, out: str, tag: str) -> None:
        """See :class:`Target`."""
        if part.identity:
            self.identity(part, source, out)
        elif part.formula is not None or part.straight:
            self.inline(part, source, out, tag)
        else:
            arguments = ", ".join(self.ref(source, c) for c in range(part.source, part.source_stop))
            time = "time, " if part.timed else ""
            self.w(f"found = {part.role}({time}array(({arguments},)))", *length_check(part))
            for c in range(part.start, part.stop):
                self.w(f"{self.ref(out, c)} = found[{c - part.start}]")

    def load(self, names: Sequence[str]) -> None:
        """See :class:`Target`."""
        for name in names:
            place = self.reserve(name, self.d)
            self.w(*(f"{self.ref(name, c)} = x[{place + c}]" for c in range(self.d)))

    def store(self, names: Sequence[str]) -> None:
        """See :class:`Target`."""
        for name in names:
            place = self.reserve(name, self.d)
            self.w(*(f"x[{place + c}] = {self.ref(name, c)}" for c in range(self.d)))


@dataclass
class _Loop:
    """A loop over components as it stands in the source."""

    #: Number of its line ``while``, and of the line after it.
    head: int
    end: int
    depth: int
    start: int
    stop: int
    counter: str
    statements: list[str]  #: As they were requested.


class ArrayTarget(Target):
    """Components are entries of one work array ``x``; a vector is a slice at a fixed offset."""

    def __init__(self, shape: Shape, writer: Writer) -> None:
        super().__init__(shape, writer)
        #: Components start..stop of a vector that live elsewhere: name -> (start, stop, place).
        self.elsewhere: dict[str, tuple[int, int, int]] = {}
        #: Vectors whose entries are used only in the loop that computes them: local variables.
        self.passing: set[str] = set()
        #: The loop that :meth:`vec` wrote last.
        self.last: _Loop | None = None

    def place(self, name: str, c: int) -> int:
        """Return what an index is added to in the work array for components from c on."""
        start, stop, place = self.elsewhere.get(name, (0, 0, 0))
        return place - start if start <= c < stop else self.offset(name)

    def ref(self, name: str, c: int) -> str:
        """See :class:`Target`."""
        return f"x[{self.place(name, c) + c}]"

    @contextmanager
    def loop(self, low: int, high: int) -> Iterator[str]:
        """Write a loop over a range as a while statement with its own counter.

        This halves the work of numba.
        """
        self.loops += 1
        c = f"c{self.loops}"
        self.w(f"{c} = {low}")
        with self.w.block(f"while {c} < {high}:"):
            yield c
            self.w(f"{c} += 1")

    def vec(self, lines: Sequence[str], part: tuple[int, int] | None = None) -> None:
        """See :class:`Target`.

        Two loops in a row over the same components become one, and so do two with the same
        statements over components in a row.
        """
        low, high = part or (0, self.d)
        names = _REFERENCE.findall(" ".join(lines))
        moved = [self.elsewhere.get(name) for name in names]
        cuts = {low, high, *(c for place in moved if place for c in place[:2] if low < c < high)}
        for start, stop in pairwise(sorted(cuts)):
            if any(moved) or not self._joined(lines, start, stop):
                head = len(self.w.lines) + 1
                with self.loop(start, stop) as c:
                    self._each(lines, c, start)
                self.last = _Loop(head, 0, self.w.depth, start, stop, c, list(lines))
            assert self.last is not None
            self.last.end = len(self.w.lines)
            done = " ".join(self.last.statements)
            assert all(f"@{name} = " in done for name in self.passing.intersection(names))

    def _joined(self, lines: Sequence[str], start: int, stop: int) -> bool:
        """Let the loop just written do these statements too; whether that is possible."""
        last = self.last
        if last is None or (last.end, last.depth) != (len(self.w.lines), self.w.depth):
            return False
        if (last.start, last.stop) == (start, stop):
            step = self.w.lines.pop()
            self.w.depth += 1
            self._each(lines, last.counter, start)
            self.w.depth -= 1
            self.w.lines.append(step)
            last.statements += lines
            return True
        if last.stop != start or last.statements != list(lines):
            return False
        margin = "    " * last.depth
        self.w.lines[last.head] = f"{margin}while {last.counter} < {stop}:"
        last.stop = stop
        return True

    def _each(self, lines: Sequence[str], c: str, low: int) -> None:
        """Write statements inside a loop with the counter ``c``, which begins at ``low``."""

        def entry(name: str) -> str:
            return f"{name}_" if name in self.passing else f"x[{self.place(name, low)} + {c}]"

        for line in lines:
            self.w(_COUNTER.sub(c, _REFERENCE.sub(lambda match: entry(match[1]), line)))

    def total(self, name: str, template: str, part: tuple[int, int] | None = None) -> None:
        """See :class:`Target`."""
        low, high = part or (0, self.d)
        self.loops += 1
        sums = [f"sum{self.loops}{letter}" for letter in "abcd"]
        # four running sums: additions of one do not wait for those of another
        self.w(*(f"{x} = 0.0" for x in sums))
        whole = low + (high - low) // 4 * 4
        c = f"c{self.loops}"
        self.w(f"{c} = {low}")
        with self.w.block(f"while {c} < {whole}:"):
            for k, x in enumerate(sums):
                term = _REFERENCE.sub(lambda m: f"x[{self.place(m[1], low) + k} + {c}]", template)  # noqa: B023
                self.w(f"{x} += {term}")
            self.w(f"{c} += 4")
        rest = [self.substitute(template, c) for c in range(whole, high)]
        self.w(f"{name} = {tree_sum([*sums, *rest])}")

    def call(self, part: Part, source: str, out: str, tag: str) -> None:
        """See :class:`Target`."""
        low, high = self.offset(out) + part.start, self.offset(out) + part.stop
        start = self.offset(source)
        where = f"x[{start + part.source}:{start + part.source_stop}]"
        if part.identity:
            # nothing to compute: what reads the result reads the argument
            self.elsewhere[out] = (part.start, part.stop, start + part.source)
            return
        # `time` is set where something depends on it
        time = ("time, " if self.shape.uses_time else "t0, ") if part.timed else ""
        if part.function is not None:
            # a copy: the function may compute in place
            self.w(f"found = {part.role}({time}{where}.copy())", *length_check(part))
            with self.loop(0, part.stop - part.start) as c:
                self.w(f"x[{low} + {c}] = found[{c}]")
            return
        values = "constants" if part.body else f"par[0:{len(self.shape.values)}]"
        name = part.body_name or part.role
        self.w(f"{name}({time}{where}, {values}, x[{low}:{high}])")

    def load(self, names: Sequence[str]) -> None:
        """See :class:`Target`."""
        for name in names:
            self.offset(name)


#: Where the statements of a single trajectory live.
TARGETS: dict[str, type[Target]] = {"scalar": ScalarTarget, "array": ArrayTarget}


class LaneTarget(_Unrolled):
    """Components are rows of a work array, one entry per lane; written inside ``for l in ...``."""

    looped = True

    def __init__(self, shape: Shape, writer: Writer, width: int) -> None:
        super().__init__(shape, writer)
        self.width = width
        #: Vectors that last, where all others live and die within one pass.
        self.lasting: frozenset[str] | None = None
        #: First letters of vectors that always do: slopes F, new values n and their errors r.
        self.passing = "Fnr"

    def ref(self, name: str, c: int) -> str:
        """See :class:`Target`."""
        if self._passing(name) or c in self.local.get(name, ()):
            return f"{name}_{c}"
        return f"x[{self.offset(name) + c * self.width} + l]"

    def _passing(self, name: str) -> bool:
        """Return whether a vector is used only in the pass over the lanes that computes it."""
        if self.lasting is not None:
            return name not in self.lasting
        return name[0] in self.passing

    def lane(self, name: str) -> str:
        """Return the source of a quantity with one entry per lane."""
        return f"x[{self.reserve(name, self.width)} + l]"

    def call(self, part: Part, source: str, out: str, tag: str) -> None:
        """See :class:`Target`."""
        if part.identity:
            self.identity(part, source, out)
        else:
            self.inline(part, source, out, tag)


class VectorTarget(ArrayTarget):
    """The loops of an array, where each number is a vector of lanes; nothing loops over lanes."""

    def lane(self, name: str) -> str:
        """Return the source of a quantity with one number per lane."""
        return f"x[{self.reserve(name, 1)}]"
