"""Ordinary functions of the method say their types; kernels and their functions, which Taichi compiles, cannot."""

import ast
from pathlib import Path

from taichi_silo import mpm


def test_every_ordinary_function_is_annotated():
    bare = []
    for file in sorted(Path(mpm.__file__).parent.rglob("*.py")):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if not isinstance(node, ast.FunctionDef):
                continue
            if any(ast.unparse(one) in ("ti.func", "ti.pyfunc", "ti.kernel") for one in node.decorator_list):
                continue
            given = [*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs]
            unsaid = [one.arg for one in given if one.annotation is None and one.arg not in ("self", "cls")]
            if unsaid or (node.returns is None and node.name != "__init__"):
                bare.append(f"{file.name}:{node.lineno} {node.name} {' '.join(unsaid)}")
    assert not bare
