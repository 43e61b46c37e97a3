"""Mutants of the kernel and of the table of implications: each must be noticed.

``python -m tests.adversary.mutation [MODULE..]`` changes one comparison, one connective, one
quantifier or one negation at a time, runs the cases of :func:`cases` in a child process, and names
the mutants that nothing notices.
"""

from __future__ import annotations

import ast
import importlib
import os
import signal
import sys
import zlib
from collections.abc import Iterator
from typing import Any

MODULES = ("kernel", "series", "algebra", "implications", "forest")
#: What holds on to names of a module, and is executed again after it.
DEPENDENTS = {
    "forest": ("series", "algebra", "kernel", "finders"),
    "series": ("kernel", "finders"),
    "algebra": ("kernel", "finders"),
    "implications": ("kernel", "finders"),
    "kernel": ("finders",),
}
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


def sample(share: int) -> Iterator[tuple[str, str, ast.Module]]:
    """One mutant in ``share`` of kernel and table of implications: module, label, tree.

    A mutant is drawn by its text, so that a change of the code elsewhere draws no others.
    """
    for name in ("kernel", "implications"):
        module = importlib.import_module(f"glmref.prove.{name}")
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


#: Mutants that no case can notice, and why.
EQUIVALENT = {
    "q == top and free  ->  True and free": "below the order a defect that is one number for all "
    "stages vanishes: without it the conditions of the next order would hold for another series",
    "smaller is None or not self.exact or (not _is_glm_exact(smaller))  ->  "
    "smaller is None or not self.exact or False": "a smaller method in decimals is never shown to "
    "agree: the claim stays open",
    "x not in gone  ->  x in gone": "the walk shows a cycle to readers and to the certificate; the "
    "verdict is that of `acyclic`",
    "known.lower > 0  ->  known.lower >= 0": "the bound is the smaller of this one and known.lower",
}


def survivors(share: int) -> list[str]:
    """Mutants of a sample that nothing notices and that are not named above."""
    docs = [d for _, d in cases()]
    expected = [answers(d) for d in docs]
    return [
        f"{name} {label}"
        for name, label, tree in sample(share)
        if _text(label) not in EQUIVALENT and not noticed(name, tree, expected, docs)
    ]


def answers(doc: Any) -> Any:
    if doc == "nothing proposed":
        return _nothing_proposed()
    from glmref.catalogue.reader import load_document
    from glmref.errors import GlmrefError
    from glmref.verification.verifier import _refute, verify

    try:
        method = load_document(doc)
        found = verify(method) if "broken" not in doc else [_refute(method, doc["broken"])]
        return [(x.claim, str(x.verdict), str(x.proof), str(x.value)) for x in found]
    except GlmrefError as error:
        return type(error).__name__


def noticed(name: str, tree: ast.Module, expected: list[Any], docs: list[Any]) -> bool:
    """Run a mutant in a child: whether any answer differs, or it does not come to an end."""
    child = os.fork()
    if child == 0:
        signal.alarm(90)
        code = 1
        try:
            module = importlib.import_module(f"glmref.prove.{name}")
            for other in DEPENDENTS[name]:
                importlib.import_module(f"glmref.prove.{other}")
            before = {id(x): key for key, x in vars(module).items()}
            exec(compile(tree, module.__file__ or "", "exec"), module.__dict__)
            # who imported a name of the module gets the new one
            for room in [x for key, x in sys.modules.items() if key.startswith("glmref.")]:
                for key, x in list(vars(room).items()):
                    if id(x) in before:
                        setattr(room, key, vars(module)[before[id(x)]])
            for other in DEPENDENTS[name]:
                follower = importlib.import_module(f"glmref.prove.{other}")
                with open(follower.__file__ or "", encoding="utf-8") as file:
                    exec(compile(file.read(), follower.__file__ or "", "exec"), follower.__dict__)
            code = int(any(answers(d) != e for d, e in zip(docs, expected, strict=True)))
        except BaseException:
            code = 1
        os._exit(code)
    _, status = os.waitpid(child, 0)
    return status != 0


def main(names: tuple[str, ...] = MODULES) -> int:
    """Report the mutants that survive; the number of them."""
    import time

    docs = [d for _, d in cases()]
    expected, times = [], []
    for label, d in cases():
        start = time.perf_counter()
        expected.append(answers(d))
        times.append((time.perf_counter() - start, label))
    order = sorted(range(len(docs)), key=lambda i: times[i][0])
    docs, expected = [docs[i] for i in order], [expected[i] for i in order]
    print(f"{len(docs)} cases in {sum(t for t, _ in times):.1f} s")
    total = survivors = 0
    for name in names:
        module = importlib.import_module(f"glmref.prove.{name}")
        with open(module.__file__ or "", encoding="utf-8") as file:
            tree = ast.parse(file.read())
        for where, mutant in mutants(tree):
            total += 1
            if not noticed(name, mutant, expected, docs):
                survivors += 1
                print(f"{name} {where}", flush=True)
    print(f"{total} mutants, {survivors} survive")
    return survivors


if __name__ == "__main__":
    sys.exit(bool(main(tuple(sys.argv[1:]) or MODULES)))
