"""Small changes of a module, each given by the text that it replaces."""

import ast
from collections.abc import Iterator
from dataclasses import dataclass

_COMPARE: dict[type[ast.cmpop], type[ast.cmpop]] = {
    ast.Is: ast.IsNot, ast.IsNot: ast.Is, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq, ast.Lt: ast.LtE,
    ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt, ast.In: ast.NotIn, ast.NotIn: ast.In,
}  # fmt: skip
_ARITHMETIC: dict[type[ast.operator], type[ast.operator]] = {
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Add, ast.Div: ast.Mult,
    ast.FloorDiv: ast.Mult, ast.Mod: ast.FloorDiv, ast.Pow: ast.Mult,
}  # fmt: skip
_EACH = {"all": "any", "any": "all"}


@dataclass(frozen=True)
class Mutant:
    """One change."""

    #: Where what is changed begins.
    line: int
    column: int
    #: What was changed: ``comparison``, ``arithmetic``, ``connective``, ``quantifier``,
    #: ``negation``, ``constant``, ``statement`` or ``return``.
    kind: str
    #: The text, and what stands in its place.
    before: str
    after: str
    source: str  #: The module with the change.
    #: Qualified name of the function that is changed, ``""`` for what is computed on import.
    function: str


def mutants(source: str) -> Iterator[Mutant]:
    """Yield every mutant of the text of a module, in the order of the syntax tree.

    Docstrings, annotations and imports stay as they are.
    """
    tree = ast.parse(source)
    still, functions = _left_alone(tree), _functions(tree)
    starts = [0]
    for line in source.encode().splitlines(keepends=True):
        starts.append(starts[-1] + len(line))
    text = source.encode()
    for node in ast.walk(tree):
        if id(node) in still or not hasattr(node, "end_lineno"):
            continue
        begin = starts[node.lineno - 1] + node.col_offset  # type: ignore[attr-defined]
        end = starts[node.end_lineno - 1] + node.end_col_offset  # type: ignore[attr-defined]
        before = text[begin:end].decode()
        for kind, after in _changes(node):
            changed = text[:begin] + after.encode() + text[end:]
            place = node.lineno, node.col_offset  # type: ignore[attr-defined]
            function = functions.get(id(node), "")
            yield Mutant(*place, kind, before, after, changed.decode(), function)


def _functions(tree: ast.Module) -> dict[int, str]:
    """Return the qualified names of the outermost functions in whose bodies nodes are."""
    found: dict[int, str] = {}

    def look(node: ast.AST, prefix: str) -> None:
        for inner in ast.iter_child_nodes(node):
            if isinstance(inner, ast.FunctionDef):
                for statement in inner.body:
                    found.update((id(x), f"{prefix}{inner.name}") for x in ast.walk(statement))
            else:
                name = f"{prefix}{inner.name}." if isinstance(inner, ast.ClassDef) else prefix
                look(inner, name)

    look(tree, "")
    return found


def _left_alone(tree: ast.Module) -> set[int]:
    """Return nodes whose change would change no behaviour, or nothing but a type."""
    found: set[int] = set()

    def leave(node: ast.AST | None) -> None:
        if node is not None:
            found.update(id(x) for x in ast.walk(node))

    for node in ast.walk(tree):
        match node:
            case ast.Expr(value=ast.Constant()):
                leave(node)
            case ast.Import() | ast.ImportFrom() | ast.JoinedStr() | ast.Raise() | ast.Assert():
                leave(node)
            case ast.AnnAssign() | ast.arg():
                leave(node.annotation)
            case ast.FunctionDef():
                leave(node.returns)
                for decorator in node.decorator_list:
                    leave(decorator)
            case ast.Assign(targets=[ast.Name(id="__all__" | "__slots__")]):
                leave(node)
            case ast.keyword(arg="strict"):  # a guard of lengths that are equal
                leave(node)
            case ast.If(test=ast.Name(id="TYPE_CHECKING")):
                leave(node)
    return found


def _changes(node: ast.AST) -> Iterator[tuple[str, str]]:
    """Yield texts that may stand in place of a node, with the kind of the change."""
    if isinstance(node, ast.Compare):
        for k, operator in enumerate(node.ops):
            operators = list(node.ops)
            operators[k] = _COMPARE[type(operator)]()
            yield "comparison", _text(ast.Compare(node.left, operators, node.comparators))
    elif isinstance(node, ast.BinOp) and type(node.op) in _ARITHMETIC:
        if not any(isinstance(x, ast.Constant) and isinstance(x.value, str)
                   for x in (node.left, node.right)):  # fmt: skip
            yield (
                "arithmetic",
                _text(ast.BinOp(node.left, _ARITHMETIC[type(node.op)](), node.right)),
            )
    elif isinstance(node, ast.BoolOp):
        other = ast.And() if isinstance(node.op, ast.Or) else ast.Or()
        yield "connective", _text(ast.BoolOp(other, node.values))
        for k in range(len(node.values)):  # one condition dropped
            rest = [*node.values[:k], *node.values[k + 1 :]]
            yield "connective", _text(rest[0] if len(rest) == 1 else ast.BoolOp(node.op, rest))
    elif isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in _EACH:
        yield "quantifier", _text(ast.Call(ast.Name(_EACH[node.func.id]), node.args, []))
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not | ast.USub):
        yield "negation", _text(node.operand)
    elif isinstance(node, ast.Constant):
        if isinstance(node.value, bool):
            yield "constant", str(not node.value)
        elif isinstance(node.value, int | float):
            yield "constant", _text(ast.Constant(node.value + 1))
    elif isinstance(node, ast.Return) and node.value is not None:
        if not (isinstance(node.value, ast.Constant) and node.value.value is None):
            yield "return", "return None"
    elif isinstance(node, ast.Assign | ast.AugAssign | ast.Expr | ast.Continue | ast.Break):
        yield "statement", "pass"
    elif isinstance(node, ast.IfExp):
        changed = ast.IfExp(ast.UnaryOp(ast.Not(), node.test), node.body, node.orelse)
        yield "negation", _text(changed)


def _text(node: ast.expr) -> str:
    """Return the text of an expression that stands anywhere."""
    return f"({ast.unparse(ast.fix_missing_locations(node))})"
