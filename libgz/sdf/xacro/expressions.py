"""Expressions: Python's syntax, evaluated on its tree. Only what is named here is evaluated; nothing is compiled."""

from __future__ import annotations

import ast
import warnings
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Protocol

from libgz.sdf.xacro.functions import Function, Namespace, method_of
from libgz.sdf.xacro.limits import (
    DEEPEST_BRACKET,
    DEEPEST_EXPRESSION,
    LONGEST_EXPRESSION,
    Budget,
    ExpansionError,
    LimitError,
    small,
)
from libgz.sdf.xacro.operations import BINARY, COMPARISONS, UNARY, items_of, key_of
from libgz.sdf.xacro.scopes import Scope

__all__ = ["Evaluator", "Names"]

CONSTANTS = (bool, int, float, complex, str, type(None))
# What an operation of a file's values can raise.
FAILURES = (ArithmeticError, AttributeError, LookupError, NameError, TypeError, ValueError)


class Names(Protocol):
    """Where an expression finds the values of its names."""

    def __getitem__(self, name: str, /) -> Any: ...

    def __contains__(self, name: object, /) -> bool: ...


@dataclass(frozen=True, eq=False)
class Lambda:
    """A function that an expression defines."""

    tree: ast.Lambda
    defaults: tuple[Any, ...]
    names: Names

    def __repr__(self) -> str:
        return "<function <lambda>>"


class _Local:
    """Names of a comprehension or function over those around it."""

    def __init__(self, names: Names) -> None:
        self.own: dict[str, Any] = {}
        self.around = names

    def __getitem__(self, name: str) -> Any:
        return self.own[name] if name in self.own else self.around[name]

    def __contains__(self, name: object) -> bool:
        return name in self.own or name in self.around


class Evaluator:
    """Evaluates expressions; `budget` counts what they use."""

    def __init__(self, budget: Budget) -> None:
        self.budget = budget
        self._depth = 0
        self._trees: dict[str, ast.expr] = {}

    def evaluate(self, text: str, names: Names) -> Any:
        """The value of an expression.

        Raises:
            ExpansionError: it is wrong, or uses what is not allowed.
            LimitError: it is too large, or its values would be.
        """
        depth = self._depth
        try:
            return self._value(self._tree(text.strip()), names)
        except (RecursionError, MemoryError):
            raise LimitError("it is nested too deeply") from None
        except FAILURES as error:
            said = error.args[0] if isinstance(error, KeyError) and error.args else error
            raise ExpansionError(f"{type(error).__name__}: {str(said)[:200]}") from None
        finally:
            self._depth = depth

    def call(self, function: Any, /, *args: Any, **named: Any) -> Any:
        """Call a function of an expression."""
        if isinstance(function, Function):
            self.budget.spend(1)
            return function.run(self, *args, **named)
        if isinstance(function, Lambda):
            return self._call_lambda(function, args, named)
        raise ExpansionError(f"{type(function).__name__!r} cannot be called")

    # Syntax ----------------------------------------------------------------------------------------------------------

    def _tree(self, text: str) -> ast.expr:
        if (tree := self._trees.get(text)) is not None:
            return tree
        if len(text) > LONGEST_EXPRESSION:
            raise LimitError(f"an expression has more than {LONGEST_EXPRESSION} characters")
        depth = 0
        for character in text:
            depth += (character in "([{") - (character in ")]}")
            if depth > DEEPEST_BRACKET:
                raise LimitError(f"brackets are nested more than {DEEPEST_BRACKET} deep")
        self.budget.spend(1 + len(text) // 4)
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # of unknown escape sequences in texts
                tree = ast.parse(text, mode="eval").body
        except SyntaxError as error:
            raise ExpansionError(f"invalid syntax: {error.msg}") from None
        self._trees[text] = tree
        return tree

    def _value(self, tree: ast.expr, names: Names) -> Any:
        evaluate = _NODES.get(type(tree))
        if evaluate is None:
            raise ExpansionError(f"{_described(tree)} cannot be used in expressions")
        self.budget.spend(1)
        self._depth += 1
        if self._depth > DEEPEST_EXPRESSION:
            raise LimitError(f"operations are nested more than {DEEPEST_EXPRESSION} deep")
        value = evaluate(self, tree, names)
        self._depth -= 1
        return value

    # Nodes -----------------------------------------------------------------------------------------------------------

    def _constant(self, tree: ast.Constant, names: Names) -> Any:
        if not isinstance(tree.value, CONSTANTS):
            raise ExpansionError(f"{_described(tree)} cannot be used in expressions")
        return small(tree.value)

    def _name(self, tree: ast.Name, names: Names) -> Any:
        try:
            return names[tree.id]
        except KeyError:
            raise ExpansionError(f"name {tree.id!r} is not defined") from None

    def _binary(self, tree: ast.BinOp, names: Names) -> Any:
        rest: list[ast.BinOp] = []
        left: ast.expr = tree
        while isinstance(left, ast.BinOp):  # a + b + c is a tree as deep as it is long
            rest.append(left)
            left = left.left
        value = self._value(left, names)
        for one in reversed(rest):
            operation = BINARY.get(type(one.op))
            if operation is None:
                raise ExpansionError(f"the operator of {_described(one)} cannot be used in expressions")
            self.budget.spend(1)
            value = operation(self.budget, value, self._value(one.right, names))
        return value

    def _unary(self, tree: ast.UnaryOp, names: Names) -> Any:
        return UNARY[type(tree.op)](self._value(tree.operand, names))

    def _boolean(self, tree: ast.BoolOp, names: Names) -> Any:
        ends = isinstance(tree.op, ast.Or)
        value: Any = None
        for part in tree.values:
            value = self._value(part, names)
            if bool(value) is ends:
                break
        return value

    def _comparison(self, tree: ast.Compare, names: Names) -> bool:
        left = self._value(tree.left, names)
        for operator, part in zip(tree.ops, tree.comparators, strict=True):
            right = self._value(part, names)
            if not COMPARISONS[type(operator)](self.budget, left, right):
                return False
            left = right
        return True

    def _condition(self, tree: ast.IfExp, names: Names) -> Any:
        return self._value(tree.body if self._value(tree.test, names) else tree.orelse, names)

    def _list(self, tree: ast.List, names: Names) -> list[Any]:
        return self._items(tree.elts, names)

    def _tuple(self, tree: ast.Tuple, names: Names) -> tuple[Any, ...]:
        return tuple(self._items(tree.elts, names))

    def _set(self, tree: ast.Set, names: Names) -> set[Any]:
        return {key_of(self.budget, item) for item in self._items(tree.elts, names)}

    def _items(self, trees: list[ast.expr], names: Names) -> list[Any]:
        made: list[Any] = []
        for tree in trees:
            if isinstance(tree, ast.Starred):
                made.extend(items_of(self.budget, self._value(tree.value, names)))
            else:
                made.append(self._value(tree, names))
        self.budget.items(len(made))
        return made

    def _dict(self, tree: ast.Dict, names: Names) -> dict[Any, Any]:
        made: dict[Any, Any] = {}
        for key, value in zip(tree.keys, tree.values, strict=True):
            if key is None:
                made.update(self._mapping(self._value(value, names)))
            else:
                made[key_of(self.budget, self._value(key, names))] = self._value(value, names)
        self.budget.items(len(made))
        return made

    def _mapping(self, value: Any) -> dict[Any, Any]:
        if not isinstance(value, dict):
            raise ExpansionError(f"{type(value).__name__!r} is not a dictionary")
        self.budget.items(len(value))
        return value

    def _subscript(self, tree: ast.Subscript, names: Names) -> Any:
        value = self._value(tree.value, names)
        if isinstance(tree.slice, ast.Slice):
            parts = (tree.slice.lower, tree.slice.upper, tree.slice.step)
            key: Any = slice(*(None if part is None else self._value(part, names) for part in parts))
            if isinstance(value, str):
                self.budget.length(len(value))
            else:
                items_of(self.budget, value)
        else:
            key = key_of(self.budget, self._value(tree.slice, names))
        if isinstance(value, str | list | tuple | dict | range):
            return value[key]
        if isinstance(value, Namespace | Scope):
            return self._member(value, str(key))
        raise ExpansionError(f"{type(value).__name__!r} has no items")

    def _attribute(self, tree: ast.Attribute, names: Names) -> Any:
        return self._member(self._value(tree.value, names), tree.attr)

    def _member(self, value: Any, name: str) -> Any:
        """A method, an item of a dictionary, or a name of a namespace; never an attribute of an object."""
        if isinstance(value, Namespace):
            if name in value.members:
                return value.members[name]
        elif isinstance(value, Scope):
            if name in value:
                return value[name]
        elif (method := method_of(value, name)) is not None:
            return method
        elif isinstance(value, dict):
            if name in value:
                return value[name]
            raise ExpansionError(f"the dictionary has no key {name!r}")
        what = value.name if isinstance(value, Namespace | Function) else type(value).__name__
        raise ExpansionError(f"{what!r} has no {name!r} that expressions can use")

    def _call(self, tree: ast.Call, names: Names) -> Any:
        function = self._value(tree.func, names)
        args = self._items(tree.args, names)
        named: dict[str, Any] = {}
        for keyword in tree.keywords:
            value = self._value(keyword.value, names)
            named.update({keyword.arg: value} if keyword.arg is not None else self._mapping(value))
        return self.call(function, *args, **named)

    def _lambda(self, tree: ast.Lambda, names: Names) -> Lambda:
        given = tree.args
        if given.vararg or given.kwarg or given.kwonlyargs:
            raise ExpansionError("a lambda has simple parameters only")
        return Lambda(tree, tuple(self._value(default, names) for default in given.defaults), names)

    def _call_lambda(self, function: Lambda, args: tuple[Any, ...], named: Mapping[str, Any]) -> Any:
        given = function.tree.args
        parameters = [one.arg for one in (*given.posonlyargs, *given.args)]
        local = _Local(function.names)
        if function.defaults:
            local.own.update(zip(parameters[-len(function.defaults) :], function.defaults, strict=True))
        local.own.update(zip(parameters, args, strict=False))
        local.own.update(named)
        if len(args) > len(parameters) or set(local.own) != set(parameters):
            raise ExpansionError(f"the lambda has the parameters ({', '.join(parameters)})")
        return self._value(function.tree.body, local)

    # Comprehensions --------------------------------------------------------------------------------------------------

    def _list_comprehension(self, tree: ast.ListComp | ast.GeneratorExp, names: Names) -> list[Any]:
        made: list[Any] = []
        for local in self._rows(tree.generators, _Local(names)):
            made.append(self._value(tree.elt, local))
        self.budget.items(len(made))
        return made

    def _set_comprehension(self, tree: ast.SetComp, names: Names) -> set[Any]:
        rows = self._rows(tree.generators, _Local(names))
        return {key_of(self.budget, self._value(tree.elt, local)) for local in rows}

    def _dict_comprehension(self, tree: ast.DictComp, names: Names) -> dict[Any, Any]:
        made: dict[Any, Any] = {}
        for local in self._rows(tree.generators, _Local(names)):
            key = key_of(self.budget, self._value(tree.key, local))
            made[key] = self._value(tree.value, local)
        return made

    def _rows(self, generators: list[ast.comprehension], local: _Local) -> Iterator[_Local]:
        """The names of each turn of nested loops, the outermost first."""
        loop, *rest = generators
        if loop.is_async:
            raise ExpansionError("async cannot be used in expressions")
        for item in items_of(self.budget, self._value(loop.iter, local)):
            inner = _Local(local)  # each turn has its own, for functions that are made in it
            self._bind(loop.target, item, inner)
            if all(self._value(condition, inner) for condition in loop.ifs):
                if rest:
                    yield from self._rows(rest, inner)
                else:
                    yield inner

    def _bind(self, target: ast.expr, value: Any, local: _Local) -> None:
        if isinstance(target, ast.Name):
            local.own[target.id] = value
            return
        if not isinstance(target, ast.Tuple | ast.List):
            raise ExpansionError(f"{_described(target)} cannot be the variable of a loop")
        items = items_of(self.budget, value)
        if len(items) != len(target.elts):
            raise ExpansionError(f"{len(target.elts)} variables of a loop get {len(items)} values")
        for part, item in zip(target.elts, items, strict=True):
            self._bind(part, item, local)


def _described(tree: ast.expr) -> str:
    """The source of a tree, for messages."""
    try:
        return repr(ast.unparse(tree)[:80])
    except (RecursionError, ValueError):
        return f"a {type(tree).__name__}"


_NODES: dict[type[ast.expr], Callable[[Evaluator, Any, Names], Any]] = {
    ast.Attribute: Evaluator._attribute,
    ast.BinOp: Evaluator._binary,
    ast.BoolOp: Evaluator._boolean,
    ast.Call: Evaluator._call,
    ast.Compare: Evaluator._comparison,
    ast.Constant: Evaluator._constant,
    ast.Dict: Evaluator._dict,
    ast.DictComp: Evaluator._dict_comprehension,
    ast.GeneratorExp: Evaluator._list_comprehension,
    ast.IfExp: Evaluator._condition,
    ast.Lambda: Evaluator._lambda,
    ast.List: Evaluator._list,
    ast.ListComp: Evaluator._list_comprehension,
    ast.Name: Evaluator._name,
    ast.Set: Evaluator._set,
    ast.SetComp: Evaluator._set_comprehension,
    ast.Subscript: Evaluator._subscript,
    ast.Tuple: Evaluator._tuple,
    ast.UnaryOp: Evaluator._unary,
}
