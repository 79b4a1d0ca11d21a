"""What is decorated in a user's own program works beside this one as it does without."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from taichi_silo.mpm.language import NAME, ti

PROGRAM = """from taichi_silo.mpm.language import ti
ti.init(arch=ti.cpu, log_level=ti.ERROR)
@ti.func
def twice(x):
    return 2 * x
@ti.kernel
def four() -> ti.i32:
    return twice(2)
print("found", four())
"""


@ti.data_oriented
class Body:
    def __init__(self, weight):
        self.weight = weight

    @property
    def double(self):
        return 2 * self.weight

    @ti.func
    def heavier(self, by):
        return self.weight + by

    @ti.kernel
    def sum(self, by: ti.i32) -> ti.i32:
        return self.heavier(by)


class Heavy(Body):
    @property
    def double(self):
        return 2 * super().double


@ti.data_oriented
class Static:
    @staticmethod
    @ti.kernel
    def three() -> ti.i32:
        return 3


def test_a_formula_in_the_first_lines_of_a_program_is_decorated(tmp_path):
    file = tmp_path / "own.py"
    file.write_text(PROGRAM)
    found = os.pathsep.join([str(Path(__file__).parents[3]), *filter(None, [os.environ.get("PYTHONPATH")])])
    environment = os.environ | {"PYTHONPATH": found}
    done = subprocess.run([sys.executable, file], env=environment, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    assert "found 4" in done.stdout


def test_kernels_properties_and_functions_of_a_class_are_an_object_s_own():
    light, heavy = Body(1), Heavy(10)
    assert (light.sum(2), heavy.sum(2), light.sum(3)) == (3, 12, 4)
    assert (light.double, heavy.double) == (2, 40)
    assert Body.sum is not light.sum and light.sum.__name__ == "sum"


@pytest.mark.skipif(NAME != "taichi", reason="its fork has no static kernels of a class")
def test_a_static_kernel_of_a_class_needs_no_object():
    assert Static().three() == 3
