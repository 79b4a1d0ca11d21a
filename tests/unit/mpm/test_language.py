"""Which language kernels are compiled in, and that objects of frozen classes reach kernels whole."""

import importlib.util
import os
import subprocess
import sys

import pytest

from taichi_silo.mpm import language
from taichi_silo.mpm.frozen import frozen, replaced
from taichi_silo.mpm.language import ti

INSTALLED = [name for name in language.LANGUAGES if importlib.util.find_spec(name)]
MISSING = [name for name in language.LANGUAGES if name not in INSTALLED]


def program(*words, asked):
    """`taichi-silo` with a language asked for; an empty string: with none."""
    return subprocess.run(
        [sys.executable, "-m", "taichi_silo.cli.app", *words], capture_output=True, text=True,
        env=os.environ | {language.VARIABLE: asked},
    )  # fmt: skip


@pytest.mark.parametrize("asked", ["Taichi", "numba", *MISSING])
def test_a_language_that_is_unknown_or_not_installed_is_refused_in_a_sentence(asked, tmp_path):
    done = program("run", "mass_flow", "--output", str(tmp_path / "run"), asked=asked)
    assert done.returncode == 2 and "Traceback" not in done.stderr
    assert done.stderr.count("\n") == 1 and language.VARIABLE in done.stderr and asked in done.stderr


@pytest.mark.parametrize(("asked", "taken"), [("", INSTALLED[0]), *((name, name) for name in INSTALLED)])
def test_taichi_is_taken_where_it_is_installed_unless_another_is_asked_for(asked, taken):
    command = "from taichi_silo.mpm import language; print(language.ti.__name__)"
    done = subprocess.run(
        [sys.executable, "-c", command], capture_output=True, text=True, env=os.environ | {language.VARIABLE: asked}
    )
    assert done.stdout == f"{taken}\n"


@frozen
class Line:
    """A straight line."""

    slope: float = 2.0

    @ti.func
    def at(self, x):
        """The ordinate at x."""
        return self.slope * x


@frozen
class Shifted(Line):
    """A straight line not through the origin."""

    start: float = 0.0

    @ti.func
    def at(self, x):
        """The ordinate at x."""
        return self.start + self.slope * x


@ti.kernel
def ordinate(line: ti.template(), x: ti.f64) -> ti.f64:
    return line.at(x)


def test_kernels_take_objects_of_frozen_classes_with_their_functions():
    assert ordinate(Line(3.0), 2.0) == 6.0
    assert ordinate(Shifted(3.0, 1.0), 2.0) == 7.0


def test_frozen_objects_are_equal_by_value_and_cannot_be_changed():
    assert Line() == Line(2.0) and hash(Line()) == hash(Line(2.0)) and Line() != Line(3.0)
    assert repr(Shifted(start=1.0)) == "Shifted(slope=2.0, start=1.0)"
    assert replaced(Shifted(start=1.0), slope=4.0) == Shifted(4.0, 1.0)
    with pytest.raises(AttributeError):
        Line().slope = 1.0
