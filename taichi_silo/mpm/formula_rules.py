"""The rules of formulas, checked on their source before anything is compiled: what breaks one is said in a sentence.

A formula is compiled for a number, for eight numbers at once on a processor's vector unit, and run by NumPy. Taichi
tells of what only some of these can do in a traceback of its own, or ends the process. The rules are in the
documentation, under "Your own law".
"""

import ast
import inspect
import textwrap
from collections.abc import Callable
from typing import Any

from taichi_silo.errors import BadInput
from taichi_silo.mpm import tensors
from taichi_silo.mpm.simd import lane_maths

NUMBER, CONSTANT, TUPLE, CONDITION, ANY = "number", "constant", "tuple", "condition", "any"  # kinds of values
OPERATORS = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.Pow: "**"}
LANGUAGE = ("max", "min", "sqrt", "select", "static")  # functions of `ti` that formulas may call
OF_TENSORS = {
    name: TUPLE if name in ("scaled", "added", "chosen", "shifted", "spun") else NUMBER
    for name, one in vars(tensors).items()
    if hasattr(one, "__wrapped__")
}
OF_LANES = ("power", "exp_minus", "exp_plus", "greatest", "larger", "smaller", "alike")
BRANCH = "it must use ti.select, as eight points are computed at once"
NO_FUNCTIONS = "formulas call ti.max, ti.min, ti.sqrt, ti.select, ti.static, those of tensors and lane_maths, and own"


class Formula:
    """The source of one formula, gone through from the top to the bottom; raises BadInput with the first breach.

    Parameters
    ----------
    function : as `ti.func` leaves it.
    name : in the sentence.
    owner : the class whose formula it is, if it is one's.
    above : formulas that call it.

    """

    def __init__(self, function: Callable, name: str, owner: type | None, above: tuple[Callable, ...] = ()):
        self.name, self.owner, self.above = name, owner, (*above, function)
        self.plain: Any = getattr(function, "__wrapped__", None)
        if self.plain is None:
            raise BadInput(f"{name} is no formula; it must have @ti.func above it")
        if function in above:
            raise BadInput(f"{name} calls itself; a formula must not")
        try:
            lines, self.first = inspect.getsourcelines(self.plain)
            tree = ast.parse(textwrap.dedent("".join(lines)))
        except (OSError, SyntaxError) as error:
            raise BadInput(f"{name} has no source that can be read; it must stand in a file or a notebook") from error
        (self.tree,) = (node for node in tree.body if isinstance(node, ast.FunctionDef))
        self.kinds: dict[str, str] = {}
        if self.plain.__code__.co_flags & 0x1000000:  # of `from __future__ import annotations`
            raise BadInput(f"the file of {name} has `from __future__ import annotations`; kernels need it without")

    def kind(self, kinds: dict[str, str]) -> str:
        """The kind of the result, where the parameters, by name and less `self`, are of these kinds."""
        given = self.tree.args
        names = [one.arg for one in given.args]
        names = names[1:] if names[:1] == ["self"] else names
        for one in given.args:
            if one.annotation is not None and "template" not in ast.unparse(one.annotation):
                self._refuse(one, f"the parameter {one.arg} has a type", "it must have none")
        if given.vararg or given.kwarg or given.defaults or given.kwonlyargs or len(names) != len(kinds):
            self._refuse(self.tree, f"takes {ast.unparse(given)}", f"it must take self, {', '.join(kinds)}")
        self.kinds = dict(zip(names, kinds.values(), strict=True))
        self.given = set(names)
        result = self._body(self.tree.body)
        if result is None:
            self._refuse(self.tree, "has no result", "its last line must be a return")
        return str(result)

    def _refuse(self, node: Any, what: str, right: str) -> Any:
        line = self.first + getattr(node, "lineno", 1) - 1
        raise BadInput(f"{self.name}, line {line}: {what}; {right}")

    # --- statements ---------------------------------------------------------------------------------------------------

    def _body(self, body: list[ast.stmt]) -> str | None:
        """The kind of what a block returns; None if it returns nothing."""
        result = None
        for number, node in enumerate(body):
            if result is not None:
                self._refuse(node, "stands behind a return", "a formula must have one return, at its end")
            if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and number == 0:
                continue  # docstring
            if isinstance(node, ast.Return):
                result = self._result(node)
            elif isinstance(node, ast.Assign) and len(node.targets) == 1:
                self._assign(node.targets[0], node.value)
            elif isinstance(node, ast.If):
                result = self._if(node)
            elif isinstance(node, ast.For) and _is_static(node.iter) and isinstance(node.target, ast.Name):
                self.kinds[node.target.id] = CONSTANT
                for _ in range(2):  # what is assigned in it is assigned again
                    if self._body(node.body) is not None:
                        self._refuse(node, "returns within a loop", "a formula must have one return, at its end")
            elif isinstance(node, ast.For | ast.While):
                self._refuse(node, "has a loop", "a formula must not loop, but over ti.static(range(...))")
            elif isinstance(node, ast.AugAssign):
                sign = OPERATORS.get(type(node.op), "?")
                self._refuse(node, f"assigns by {sign}=", f"it must be written x = x {sign} ...")
            else:
                what = ast.unparse(node).splitlines()[0]
                self._refuse(node, f"has the statement {what}", "formulas have assignments and a return only")
        return result

    def _if(self, node: ast.If) -> str | None:
        if _is_static(node.test):
            before = dict(self.kinds)
            first = self._body(node.body)
            after, self.kinds = self.kinds, before
            second = self._body(node.orelse)
            self.kinds = {**after, **self.kinds}
            return first or second
        test = node.test
        uniform = isinstance(test, ast.Compare) and _calls(test.left, "greatest") and not node.orelse
        if not uniform:
            self._refuse(node, "branches by a value", BRANCH)
        self._value(test)
        known = set(self.kinds)
        if self._body(node.body) is not None:
            self._refuse(node, "returns within a branch", "a formula must have one return, at its end")
        self.kinds = {name: kind for name, kind in self.kinds.items() if name in known}
        return None

    def _result(self, node: ast.Return) -> str:
        if node.value is None:
            return self._refuse(node, "returns nothing", "it must return its result")
        parts = node.value.elts if isinstance(node.value, ast.Tuple) else [node.value]
        for part in parts:
            if self._value(part) == CONSTANT:
                text = ast.unparse(part)
                self._refuse(
                    node, f"returns the plain number {text}", f"it must be {text} + 0.0 * a parameter, of lanes"
                )
        return self._value(node.value)

    def _assign(self, target: ast.expr, value: ast.expr) -> None:
        kind = self._value(value)
        if isinstance(target, ast.Tuple):
            for one in target.elts:
                self._store(one, NUMBER if kind in (TUPLE, NUMBER) and not _of_own(value) else ANY)
        else:
            self._store(target, kind)

    def _store(self, target: ast.expr, kind: str) -> None:
        """Take in that a name has a value of a kind."""
        if not isinstance(target, ast.Name):
            self._refuse(target, f"changes {ast.unparse(target)}", "a formula must change names of its own only")
        name = target.id  # type: ignore[attr-defined]
        before = self.kinds.get(name)
        if name in self.given:
            self._refuse(target, f"changes its parameter {name}", "it must give the new value a new name")
        if before is not None and TUPLE in (before, kind):
            self._refuse(target, f"assigns the tuple {name} twice", "it must give the second one a new name")
        if before == CONSTANT and kind != CONSTANT:
            self._refuse(
                target, f"begins {name} as a plain number", "it must begin as 0.0 * a parameter + that number, of lanes"
            )
        self.kinds[name] = kind

    # --- values -------------------------------------------------------------------------------------------------------

    def _value(self, node: Any) -> str:
        """The kind of an expression."""
        kind = getattr(self, f"_{type(node).__name__.lower()}", None)
        if kind is None:
            words = "formulas have numbers, names, tuples, + - * / and calls only"
            self._refuse(node, f"has the expression {ast.unparse(node)}", words)
        return kind(node)  # type: ignore[misc]

    def _constant(self, node: ast.Constant) -> str:
        if not isinstance(node.value, int | float):
            self._refuse(node, f"has the value {ast.unparse(node)}", "formulas have numbers only")
        return CONSTANT

    def _name(self, node: ast.Name) -> str:
        if node.id in self.kinds:
            return self.kinds[node.id]
        if isinstance(self.plain.__globals__.get(node.id), int | float):
            return CONSTANT
        return self._refuse(node, f"names {node.id}", "it must be assigned before, or be a number of the file")

    def _ifexp(self, node: ast.IfExp) -> str:
        return self._refuse(node, "branches by a value", BRANCH)

    def _boolop(self, node: ast.BoolOp) -> str:
        return self._refuse(node, f"joins conditions in {ast.unparse(node)}", "it must use one ti.select in another")

    def _attribute(self, node: ast.Attribute) -> str:
        if isinstance(node.value, ast.Name) and node.value.id == "self":
            if self.owner is not None and not _has(self.owner, node.attr):
                self._refuse(node, f"names self.{node.attr}", "its class must have that constant or property")
            return CONSTANT
        return self._refuse(node, f"names {ast.unparse(node)}", "formulas know names of their own and self's constants")

    def _tuple(self, node: ast.Tuple) -> str:
        for part in node.elts:
            self._value(part)
        return TUPLE

    def _subscript(self, node: ast.Subscript) -> str:
        kind = self._value(node.value)
        if kind == NUMBER or not isinstance(node.slice, ast.Constant) or not isinstance(node.slice.value, int):
            self._refuse(node, f"has {ast.unparse(node)}", "only tuples have components, by a written number")
        return NUMBER

    def _binop(self, node: ast.BinOp) -> str:
        sign = OPERATORS.get(type(node.op))
        kinds = [self._value(node.left), self._value(node.right)]
        if sign is None:
            self._refuse(node, f"has {ast.unparse(node)}", "formulas have + - * / and whole powers only")
        if TUPLE in kinds:
            self._refuse(
                node, f"computes with a tuple in {ast.unparse(node)}", "it must use added or scaled of tensors"
            )
        if CONDITION in kinds:
            self._refuse(node, f"computes with a condition in {ast.unparse(node)}", "it must stand in ti.select only")
        whole = isinstance(node.right, ast.Constant) and isinstance(node.right.value, int) and node.right.value > 0
        if sign == "**" and kinds != [CONSTANT, CONSTANT] and not whole:
            self._refuse(node, f"has {ast.unparse(node)}", "it must be power(base, exponent) of lane_maths")
        return CONSTANT if kinds == [CONSTANT, CONSTANT] else NUMBER

    def _unaryop(self, node: ast.UnaryOp) -> str:
        kind = self._value(node.operand)
        if not isinstance(node.op, ast.USub) or kind != CONSTANT:
            text = ast.unparse(node.operand)
            self._refuse(node, f"has {ast.unparse(node)}", f"lanes know no sign before a name, write 0.0 - {text}")
        return kind

    def _compare(self, node: ast.Compare) -> str:
        kinds = [self._value(one) for one in (node.left, *node.comparators)]
        if len(kinds) > 2 or TUPLE in kinds:
            self._refuse(node, f"compares {ast.unparse(node)}", "it must compare two numbers")
        return CONDITION

    def _call(self, node: ast.Call) -> str:
        if node.keywords or any(isinstance(one, ast.Starred) for one in node.args):
            self._refuse(node, f"calls {ast.unparse(node)}", "formulas are called with plain parameters")
        if _is_static(node):
            return CONSTANT
        kinds = [self._value(one) for one in node.args]
        called = node.func
        if isinstance(called, ast.Attribute) and ast.unparse(called.value) == "ti" and called.attr in LANGUAGE:
            return self._of_language(node, called.attr, kinds)
        if isinstance(called, ast.Attribute) and ast.unparse(called.value).split(".")[0] == "self":
            return self._of_self(node, called, kinds)
        if not isinstance(called, ast.Name):
            return self._refuse(node, f"calls {ast.unparse(called)}", NO_FUNCTIONS)
        function: Any = self.plain.__globals__.get(called.id)
        if function is not None and function is getattr(tensors, called.id, None):
            return OF_TENSORS[called.id]
        if called.id in OF_LANES and function is getattr(lane_maths, called.id):
            if called.id == "power" and set(kinds[1:]) != {CONSTANT}:
                self._refuse(node, f"calls {ast.unparse(node)}", "the exponent of a power must be a constant")
            return NUMBER
        if not hasattr(function, "__wrapped__"):
            return self._refuse(node, f"calls {called.id}", NO_FUNCTIONS)
        own = {f"parameter {number}": kind for number, kind in enumerate(kinds)}
        return Formula(function, called.id, self.owner, self.above).kind(own)

    def _of_language(self, node: ast.Call, name: str, kinds: list[str]) -> str:
        if TUPLE in kinds:
            right = "of tuples it must be chosen of tensors" if name == "select" else "it must be a number"
            self._refuse(node, f"calls ti.{name} with a tuple", right)
        if (name == "select") != (CONDITION in kinds):
            self._refuse(node, f"calls {ast.unparse(node)}", "a condition must be the first parameter of ti.select")
        return CONSTANT if set(kinds) <= {CONSTANT} else NUMBER

    def _of_self(self, node: ast.Call, called: ast.Attribute, kinds: list[str]) -> str:
        if ast.unparse(called.value) != "self" or self.owner is None:  # of a part, which is checked by itself
            return ANY
        function: Any = vars(self.owner).get(called.attr)
        if function is None or not hasattr(function, "__wrapped__"):
            self._refuse(node, f"calls self.{called.attr}", "it must be a @ti.func of the class")
        own = {f"parameter {number}": kind for number, kind in enumerate(kinds)}
        return Formula(function, f"{self.owner.__name__}.{called.attr}", self.owner, self.above).kind(own)


def _of_own(value: ast.expr) -> bool:
    """Whether components of a value may be tuples themselves: it is a written tuple, or of a function of self."""
    return isinstance(value, ast.Tuple) or "self." in ast.unparse(value)


def _has(owner: type, name: str) -> bool:
    return hasattr(owner, name) or any(name in getattr(base, "_hidden_fields", {}) for base in owner.__mro__)


def _is_static(node: Any) -> bool:
    return isinstance(node, ast.Call) and ast.unparse(node.func) == "ti.static"


def _calls(node: ast.expr, name: str) -> bool:
    return isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == name
