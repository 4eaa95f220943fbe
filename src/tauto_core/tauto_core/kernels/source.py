"""The syntax trees of kernels, and what they show before values are known."""

from __future__ import annotations

import ast
from functools import cache
from types import CodeType, FunctionType
from typing import Any

from tauto_core.kernels.errors import KernelError
from tauto_core.kernels.marks import IS_INLINED
from tauto_core.kernels.used import contents

SIMPLE = 60
"""A function without loops that has fewer nodes in its syntax tree is inlined."""

_LOOPS = (ast.For, ast.While)


@cache
def _definitions(path: str) -> dict[tuple[str, int], list[Any]]:
    """Return the functions of a file by what they are and their first line."""
    tree = ast.parse(contents(path))
    found: dict[tuple[str, int], list[Any]] = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef):
            first = min([node.lineno, *(each.lineno for each in node.decorator_list)])
            found.setdefault((node.name, first), []).append(node)
        elif isinstance(node, ast.Lambda):
            found.setdefault(('<lambda>', node.lineno), []).append(node)
    return found


def _node_of(code: CodeType) -> Any:
    nodes = _definitions(code.co_filename).get((code.co_name, code.co_firstlineno), [])
    if len(nodes) > 1:
        # several lambdas in one line: the one that its instructions come from
        begins = {(p[0], p[2]) for p in code.co_positions() if p[3] and p[3] > (p[2] or 0)}
        nodes = [n for n in nodes if (n.body.lineno, n.body.col_offset) in begins]
    if len(nodes) != 1:
        raise KernelError(
            f'the source of {code.co_qualname} is not in {code.co_filename}:'
            f'{code.co_firstlineno}. Has the file changed since it was imported?'
        )
    return nodes[0]


class Plan:
    """The source of a function.

    Attributes:
        arguments: names of its arguments.
        body: statements.
        simple: whether it is short and has no loop.
    """

    def __init__(self, code: CodeType) -> None:
        node = _node_of(code)
        kind = node.args
        if kind.vararg or kind.kwarg or kind.kwonlyargs:
            raise KernelError(f'{code.co_qualname} has arguments with * or by keyword only')
        self.arguments = [each.arg for each in (*kind.posonlyargs, *kind.args)]
        if isinstance(node, ast.Lambda):
            self.body: list[Any] = [ast.copy_location(ast.Return(value=node.body), node)]
        else:
            first = node.body[0]
            documented = isinstance(first, ast.Expr) and isinstance(first.value, ast.Constant)
            self.body = node.body[1:] if documented else node.body
        inside = [each for statement in self.body for each in ast.walk(statement)]
        looped = any(isinstance(each, _LOOPS) for each in inside)
        self.simple = not looped and len(inside) < SIMPLE


@cache
def _plan_of(code: CodeType) -> Plan:
    return Plan(code)


def plan_of(function: FunctionType) -> Plan:
    """Return the source of a function."""
    return _plan_of(function.__code__)


def is_inlined(function: FunctionType) -> bool:
    """Return whether a function is translated where it is called."""
    return function in IS_INLINED or plan_of(function).simple


def arguments_of(
    function: FunctionType, args: list[Any], keywords: dict[str, Any]
) -> dict[str, Any]:
    """Return the arguments of a call by their names.

    Raises:
        KernelError: there are too many, too few, or others.
    """
    names, defaults = plan_of(function).arguments, function.__defaults__ or ()
    given = dict(zip(names[len(names) - len(defaults) :], defaults, strict=True))
    given.update(zip(names, args, strict=False))
    given.update(keywords)
    if len(args) > len(names) or set(given) != set(names):
        raise KernelError(
            f'{function.__qualname__} takes {", ".join(names)}; '
            f'{len(args)} and {", ".join(keywords) or "none"} by name are given'
        )
    return given


@cache
def assigned_in(loop: Any) -> tuple[str, ...]:
    """Return the names that a loop sets, in the order of the first time."""
    return tuple(
        dict.fromkeys(
            node.id
            for node in ast.walk(loop)
            if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)
        )
    )


@cache
def leaves_early(loop: Any) -> bool:
    """Return whether a loop has a break or continue of its own or of a loop within."""
    return any(isinstance(node, (ast.Break, ast.Continue)) for node in ast.walk(loop))


@cache
def indexed_by(loop: Any) -> frozenset[str]:
    """Return the names of what is indexed by a loop's variable."""
    if not isinstance(loop.target, ast.Name):
        return frozenset()
    return frozenset(
        node.value.id
        for node in ast.walk(loop)
        if isinstance(node, ast.Subscript)
        and isinstance(node.value, ast.Name)
        and any(isinstance(n, ast.Name) and n.id == loop.target.id for n in ast.walk(node.slice))
    )
