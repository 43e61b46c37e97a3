"""Mutants of the kernel and of the table of implications: each must be noticed.

``python -m tests.adversary.mutation [MODULE..] [KNOWN.json]`` changes one comparison, one connective, one
quantifier or one negation at a time, runs the cases of :func:`cases` in a child process, and names
the mutants that nothing notices.
"""

from __future__ import annotations

import ast
import importlib
import json
import os
import resource
import sys
import zlib
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

#: The kernel with its parts, and the table of implications: a sample is drawn of these.
RULES = (
    "kernel", "growth_rules", "stability_rules", "form_rules", "rows", "ranges", "digits", "implications",
)  # fmt: skip
MODULES = (*RULES, "theory.starting_series", "algebra")
#: What holds on to names of a module, and is executed again after it.
DEPENDENTS = {
    "theory.starting_series": ("form_rules", "kernel", "finders"),
    "algebra": ("growth_rules", "stability_rules", "form_rules", "kernel", "finders"),
    "growth_rules": ("kernel", "finders"),
    "form_rules": ("kernel", "finders"),
    "stability_rules": ("kernel", "finders"),
    "rows": ("kernel", "finders"),
    "ranges": (
        "algebra",
        "growth_rules",
        "stability_rules",
        "form_rules",
        "rows",
        "kernel",
        "finders",
    ),
    "digits": ("kernel", "finders"),
    "implications": ("kernel", "finders"),
    "kernel": ("finders",),
}
#: What else notices a mutant of a module that the cases do not notice.
TESTS = {
    "theory.starting_series": ("tests/unit/test_kernel.py",),
    "algebra": ("tests/unit/test_kernel.py",),
    "implications": ("tests/unit/test_implications.py", "tests/unit/test_prove_simplifying.py"),
    "digits": ("tests/unit/test_order_to_digits.py", "tests/unit/test_embedded_values.py"),
    "kernel": (
        "tests/unit/test_kernel.py",
        "tests/unit/test_multistep_pairs.py",
        "tests/unit/test_staircase.py",
        "tests/unit/test_principal_parts.py",
    ),
    "growth_rules": ("tests/unit/test_kernel.py",),
    "form_rules": ("tests/unit/test_kernel.py",),
    "stability_rules": ("tests/unit/test_kernel.py",),
    "rows": (
        "tests/unit/test_kernel.py",
        "tests/unit/test_second_format.py",
        "tests/unit/test_embedded_values.py",
        "tests/unit/test_nystrom.py",
        "tests/unit/test_prove_simplifying.py",
    ),
    "ranges": ("tests/unit/test_kernel.py", "tests/unit/test_staircase.py"),
}
OPTIONS = ("-x", "-q", "--assert=plain", "-p", "no:cacheprovider")
_COMPARE: dict[type, type] = {
    ast.Is: ast.IsNot, ast.IsNot: ast.Is, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq, ast.Lt: ast.LtE,
    ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt, ast.In: ast.NotIn, ast.NotIn: ast.In,
}  # fmt: skip


def mutants(tree: ast.Module) -> Iterator[tuple[str, ast.Module]]:
    """The tree with one change at a time, and where it is; the change is taken back after use."""
    for node in list(ast.walk(tree)):
        for how in range(_ways(node)):
            kept = {k: list(x) if isinstance(x, list) else x for k, x in vars(node).items()}
            inner = node.func if isinstance(node, ast.Call) else None
            name = getattr(inner, "id", "")
            label = _change(node, how)
            ast.fix_missing_locations(node)
            yield f"line {getattr(node, 'lineno', 0)}: {label}", tree
            vars(node).update(kept)
            if isinstance(inner, ast.Name):
                inner.id = name


def _module(name: str) -> ModuleType:
    """A module by its name in ``glmref.prove``, or with that of its subpackage."""
    return importlib.import_module(f"glmref.{name if '.' in name else f'prove.{name}'}")


def sample(share: int) -> Iterator[tuple[str, str, ast.Module]]:
    """One mutant in ``share`` of kernel and table of implications: module, label, tree.

    A mutant is drawn by its text, so that a change of the code elsewhere draws no others.
    """
    for name in RULES:
        module = _module(name)
        with open(module.__file__ or "", encoding="utf-8") as file:
            tree = ast.parse(file.read())
        for label, mutant in mutants(tree):
            if zlib.crc32(_text(label).encode()) % share == 0:
                yield name, label, mutant


def _text(label: str) -> str:
    """What is changed, without the line."""
    return label.partition(": ")[2]


def _ways(node: ast.AST) -> int:
    if isinstance(node, ast.Compare):
        return len(node.ops)
    if isinstance(node, ast.Call) and getattr(node.func, "id", "") in ("all", "any"):
        return 1
    if isinstance(node, ast.BoolOp):
        return 1 + len(node.values)
    return int(isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not))


def _change(node: Any, how: int) -> str:
    before = ast.unparse(node)
    if isinstance(node, ast.Compare):
        node.ops[how] = _COMPARE[type(node.ops[how])]()
    elif isinstance(node, ast.Call):
        called: Any = node.func
        called.id = "any" if called.id == "all" else "all"
    elif isinstance(node, ast.BoolOp):
        if how == 0:
            node.op = ast.Or() if isinstance(node.op, ast.And) else ast.And()
        else:  # one hypothesis dropped
            node.values[how - 1] = ast.Constant(isinstance(node.op, ast.And))
    else:
        node.op, node.operand = ast.Not(), ast.UnaryOp(ast.Not(), node.operand)
    return f"{before}  ->  {ast.unparse(node)}"


def cases() -> Iterator[tuple[str, Any]]:
    """Names and documents, cheap ones first."""
    from glmref.catalogue.lookup import document

    from . import corpus

    for name in corpus.NAMES:
        yield name, document(name)
    yield from corpus.documents()
    yield "nothing proposed", "nothing proposed"


def _nothing_proposed() -> list[Any]:
    """What the kernel says where a finder hands in nothing, or what does not fit."""
    from glmref.catalogue.reader import load_document
    from glmref.prove.kernel import Kernel, Proposal

    from . import corpus

    named = dict(corpus.documents())
    found = []
    for name, claim in (("idle value", "symmetric-reduced"), ("leapfrog in balls", "symmetric-reduced"),
                        ("double one", "parasitism-free"), ("idle value", "g-symplectic")):  # fmt: skip
        if name in named:
            known = Kernel(load_document(named[name])).known(claim, Proposal())
            found.append((known.truth, known.exact))
    known = Kernel(load_document(named["inner zero"])).known("parasitism-free", _no_eigenvector())
    return [*found, (known.truth, known.exact)]


def _no_eigenvector() -> Any:
    """(0, 1, 1) for V = diag(1, -1, 0): it is read rightly by W, and V does not keep it."""
    from glmref.exact import Exact
    from glmref.prove.kernel import Proposal

    one, zero = Exact(1), Exact(0)
    parts = ((one, ((one, zero, zero),), ((one, zero, zero),)),
             (-one, ((zero, one, zero),), ((zero, one, one),)))  # fmt: skip
    return Proposal(lambda: {"o": (parts, (zero, one))})


_CARRY_ON = "all((_carries_on(*b) for x in kernels for b in x.blocks.values()))"
#: Mutants that no case can notice, and why.
EQUIVALENT = {
    "n > (6 if self.is_pair else MAX_ORDER[0] - 2)  ->  "
    "n >= (6 if self.is_pair else MAX_ORDER[0] - 2)": "one order earlier the tree with leaves alone "
    "is asked for first: another tree of the order that fails may be named",
    "not self.shared and is_exact(V, V_hat)  ->  not self.shared and True": "polynomials in balls "
    "have no greatest common divisor, and no eigenvectors of balls are proposed: open either way",
    "not nystrom and n <= MAX_ORDER[1]  ->  True and n <= MAX_ORDER[1]": "all trees decide as those "
    "without branches do, by the theorem",
    "n <= MAX_ORDER[1]  ->  n < MAX_ORDER[1]": "the same",
    "found.value > MAX_ORDER[0] - 2  ->  found.value >= MAX_ORDER[0] - 2": "of order 10 the same "
    "sizes are computed again",
    "gap > ROUNDING  ->  gap >= ROUNDING": "a magnitude is an upper bound, a float: none is the limit "
    "itself",
    "bush.magnitude() > ROUNDING  ->  bush.magnitude() >= ROUNDING": "the magnitude of a ball is an "
    "upper bound of a float: no residual has the limit itself",
    "largest > (SMALL if n + 1 <= MAX_ORDER[0] - 2 else ROUNDING)  ->  "
    "largest >= (SMALL if n + 1 <= MAX_ORDER[0] - 2 else ROUNDING)": "the same",
    "t in self._weights or not T.children[t]  ->  False or not T.children[t]": "what is kept is "
    "computed again",
    "y > GAP * most  ->  y >= GAP * most": "the number itself decides then",
    "t in self._weights  ->  t not in self._weights": "the same",
    "x > low  ->  x >= low": "of two trees with the same lower bound either shows the size",
    "t - T.level(order - 1)[0] > ONE_BRANCH  ->  t - T.level(order - 1)[0] >= ONE_BRANCH": "one "
    "tree less is tried before all are listed",
    **dict.fromkeys(
        (
            f"x <= {limit} < y  ->  {changed}"
            for limit in ("most", "least")
            for changed in (f"x < {limit} < y", f"x <= {limit} <= y")
        ),
        "bounds are whole numbers, and a size over 2^-bits is none, but for 5.0e-1",
    ),
    "n < order  ->  n <= order": "numbers are kept that nobody asks for again",
    **dict.fromkeys(
        (
            f"{condition}  ->  {changed}"
            for condition, changed in (
                (
                    "all(((x - 1).is_zero() is True for row in (*U, *V) for x in row))",
                    "any(((x - 1).is_zero() is True for row in (*U, *V) for x in row))",
                ),
                (
                    f"not kernels or not {_CARRY_ON}",
                    f"not kernels and (not {_CARRY_ON})",
                ),
            )
        ),
        "the judge refuses what is proposed then, for the same condition",
    ),
}


def survivors(share: int) -> list[str]:
    """Mutants of a sample that nothing notices and that are not named above."""
    bench = Cases()
    return [
        f"{name} {label}"
        for name, label, tree in sample(share)
        if _text(label) not in EQUIVALENT
        and not bench.notices(name, tree)
        and not noticed_by_tests(name, tree)
    ]


class Cases:
    """The cases with their answers; those that notice the most mutants are asked first."""

    def __init__(self) -> None:
        self.known = [(name, doc, answers(doc)) for name, doc in cases()]

    def notices(self, name: str, tree: ast.Module | None) -> str:
        """Run a mutant in a child: the first case whose answer differs, ``""`` if none does.

        A child that does not come to an end has noticed it too. Without a tree the module is
        executed again as it is, which nothing may notice.
        """
        reader, writer = os.pipe()

        def run() -> bool:
            for n, (_, doc, expected) in enumerate(self.known):
                if answers(doc) != expected:
                    os.write(writer, str(n).encode())
                    return True
            return False

        failed = _fails(name, tree, run)
        os.close(writer)
        with os.fdopen(reader) as stream:
            told = stream.read()
        if not failed or not told:
            return "the child" if failed else ""
        self.known.insert(0, self.known.pop(int(told)))
        return self.known[0][0]


def answers(doc: Any) -> Any:
    if doc == "nothing proposed":
        return _nothing_proposed()
    from glmref.catalogue.reader import load_document
    from glmref.errors import GlmrefError
    from glmref.prove.verifier import _refute, verify

    try:
        method = load_document(doc)
        found = verify(method) if "broken" not in doc else [_refute(method, doc["broken"])]
        return [
            (x.claim, str(x.verdict), str(x.proof), str(x.value), x.residual, x.witness)
            for x in found
        ]
    except GlmrefError as error:
        return type(error).__name__


def _execute(module: ModuleType, source: str | ast.Module) -> None:
    """Execute a module again; who imported a name of it gets the new one."""
    before = dict(vars(module))  # keeps the old objects: the number of a freed one is used again
    names = {id(x): key for key, x in before.items()}
    exec(compile(source, module.__file__ or "", "exec"), module.__dict__)
    for other in [x for key, x in sys.modules.items() if key.startswith("glmref.")]:
        for key, x in list(vars(other).items()):
            if id(x) in names:
                setattr(other, key, vars(module)[names[id(x)]])


def noticed_by_tests(name: str, tree: ast.Module | None) -> bool:
    """Run the tests of the module in a child with the mutant in its place."""

    def run() -> bool:
        import pytest

        with open(os.devnull, "w", encoding="utf-8") as nothing:
            os.dup2(nothing.fileno(), 1)
            return bool(pytest.main([*OPTIONS, *TESTS[name]]))

    return _fails(name, tree, run)


def _fails(name: str, tree: ast.Module | None, run: Callable[[], bool]) -> bool:
    child = os.fork()
    if child == 0:
        # processor time: a busy machine notices nothing
        resource.setrlimit(resource.RLIMIT_CPU, (90, 91))
        code = 1
        try:
            module = _module(name)
            for other in DEPENDENTS[name]:
                _module(other)
            with open(module.__file__ or "", encoding="utf-8") as file:
                _execute(module, file.read() if tree is None else tree)
            for other in DEPENDENTS[name]:
                follower = _module(other)
                with open(follower.__file__ or "", encoding="utf-8") as file:
                    _execute(follower, file.read())
            code = int(run())
        except BaseException:
            code = 1
        os._exit(code)
    _, status = os.waitpid(child, 0)
    return status != 0


def main(arguments: tuple[str, ...] = ()) -> int:
    """Report the mutants that survive; the number of them.

    A file among the arguments, ``NAME.json``, keeps what is known of each mutant by its text: a
    next run tries only those that survived or are new.
    """
    kept = next((Path(x) for x in arguments if x.endswith(".json")), None)
    names = tuple(x for x in arguments if not x.endswith(".json")) or MODULES
    known = json.loads(kept.read_text()) if kept is not None and kept.exists() else {}
    bench = Cases()
    total = survivors = 0
    for name in names:
        if bench.notices(name, None) or noticed_by_tests(name, None):
            raise SystemExit(f"{name} without a change gives other answers")
        module = _module(name)
        with open(module.__file__ or "", encoding="utf-8") as file:
            tree = ast.parse(file.read())
        seen: Counter[str] = Counter()
        for where, mutant in mutants(tree):
            total += 1
            seen[_text(where)] += 1
            key = f"{name} {_text(where)} #{seen[_text(where)]}"
            if _text(where) in EQUIVALENT or known.get(key):
                continue
            known[key] = bench.notices(name, mutant) or (
                "tests" if noticed_by_tests(name, mutant) else ""
            )
            if kept is not None:
                kept.write_text(json.dumps(known, indent=0))
            if not known[key]:
                survivors += 1
                print(f"{name} {where}", flush=True)
    print(f"{total} mutants, {survivors} survive")
    return survivors


if __name__ == "__main__":
    sys.exit(bool(main(tuple(sys.argv[1:]))))
