"""Mutants of the kernel and of the table of implications: each must be noticed.

``python -m tests.adversary.mutation [MODULE..]`` changes one comparison, one connective, one
quantifier or one negation at a time, runs the cases of :func:`cases` in a child process, and names
the mutants that nothing notices.
"""

from __future__ import annotations

import ast
import copy
import importlib
import os
import signal
import sys
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
    """Every tree with one change, and where it is."""
    nodes = list(ast.walk(tree))
    for k, node in enumerate(nodes):
        for how in range(_ways(node)):
            changed = copy.deepcopy(tree)
            other: Any = list(ast.walk(changed))[k]
            label = _change(other, how)
            if label:
                yield (
                    f"line {getattr(node, 'lineno', 0)}: {label}",
                    ast.fix_missing_locations(changed),
                )


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
        node.func.id = "any" if node.func.id == "all" else "all"
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


def answers(doc: Any) -> Any:
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
            exec(compile(tree, module.__file__ or "", "exec"), module.__dict__)
            for other in DEPENDENTS[name]:
                follower = importlib.import_module(f"glmref.prove.{other}")
                with open(follower.__file__ or "", encoding="utf-8") as file:
                    exec(compile(file.read(), follower.__file__ or "", "exec"), follower.__dict__)
            if name == "implications":
                import glmref.verification.verifier as v

                v.implied_by = module.implied_by
            if name == "kernel":
                import glmref.verification.verifier as v

                v.refuted = module.refuted
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
