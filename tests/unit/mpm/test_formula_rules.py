"""Whoever breaks a rule of formulas hears of it in one sentence when the part is registered, not from Taichi."""

import importlib.util
import re
import sys
import textwrap

import pytest

from taichi_silo.errors import BadInput
from taichi_silo.mpm import own_parts
from taichi_silo.mpm.laws import Elastic, GudehusBauer, Intergranular
from taichi_silo.mpm.walls import Coulomb, Frictionless, NoSlip, RoughFree
from taichi_silo.runs.plugins import load_plugin, register
from taichi_silo.utils import plugin_files

HEAD = """
import math
from taichi_silo.mpm.frozen import frozen
from taichi_silo.mpm.language import ti
from taichi_silo.mpm.simd.lane_maths import exp_minus, greatest, power
from taichi_silo.mpm.tensors import added, chosen, inner, norm, scaled, shifted, trace

TENTH, WORDS = 0.1, "words"

@ti.func
def doubled(x):
    return 2.0 * x

@ti.func
def endless(x):
    return endless(x)

def plain(x):
    return x
"""
LAW = """
@frozen
class Spring:
    modulus_Pa: float = 1e6
    grain_density: float = 2650.0
    rest_stress = 0.0
    degree = 0.0
    loosest = 1e30
    REMEMBERS = False

    def rest_pressure_ratio(self, void_ratio):
        return 0.5

    @ti.func
    def factors(self, stress, void_ratio):
        return (0.0 * void_ratio,)

    @ti.func
    def advanced_factors(self, factors, growth_of_trace, swelling):
        return factors

    @ti.func
    def rate(self, stress, h, factors, D, d_bar):
        return scaled(D, 2.0 * self.modulus_Pa)

    @ti.func
    def admissible(self, stress, void_ratio):
        return stress

    @ti.func
    def stiffness(self, stress, void_ratio):
        x = doubled(void_ratio)
        BODY
        return 0.0 * x + 2.0 * self.modulus_Pa
"""
BREACHES = {  # what stands in a formula of a law, x a number and stress a tuple: what is said of it
    "if x > 0.0:\n    x = 0.0 * x": "branches by a value; it must use ti.select",
    "x = 1.0 * x if x > 0.0 else x": "branches by a value; it must use ti.select",
    "while x > 0.0:\n    x = x - 1.0": "has a loop; a formula must not loop, but over ti.static",
    "for k in range(3):\n    x = x + k": "has a loop; a formula must not loop",
    "x += 1.0": "assigns by +=; it must be written x = x + ...",
    "void_ratio = 2.0 * x": "changes its parameter void_ratio; it must give the new value a new name",
    "s = scaled(stress, 2.0)\ns = scaled(s, 2.0)": "assigns the tuple s twice; it must give the second one a new name",
    "s = (x, x, x, x)\nfor k in ti.static(range(2)):\n    s = scaled(s, 2.0)": "assigns the tuple s twice",
    "y = 0.0\ny = y + x": "begins y as a plain number; it must begin as 0.0 * a parameter + that number",
    "y = -x": "has -x; lanes know no sign before a name, write 0.0 - x",
    "y = stress + stress": "computes with a tuple in stress + stress; it must use added or scaled",
    "y = ti.max(stress, stress)": "calls ti.max with a tuple; it must be a number",
    "y = ti.select(x > 0.0, stress, stress)": "calls ti.select with a tuple; of tuples it must be chosen of tensors",
    "y = ti.select(x, x, x)": "a condition must be the first parameter of ti.select",
    "y = (x > 0.0) * x": "computes with a condition in (x > 0.0) * x; it must stand in ti.select only",
    "y = ti.select(x > 0.0 and x < 1.0, x, x)": "joins conditions in x > 0.0 and x < 1.0; it must use one ti.select in",
    "y = ti.select(0.0 < x < 1.0, x, x)": "compares 0.0 < x < 1.0; it must compare two numbers",
    "y = x ** 0.5": "has x ** 0.5; it must be power(base, exponent) of lane_maths",
    "y = power(2.0, x)": "calls power(2.0, x); the exponent of a power must be a constant",
    "y = x % 2.0": "has x % 2.0; formulas have + - * / and whole powers only",
    "y = ti.sin(x)": "calls ti.sin; formulas call ti.max, ti.min",
    "y = math.sqrt(x)": "calls math.sqrt; formulas call ti.max, ti.min",
    "y = abs(x)": "calls abs; formulas call ti.max, ti.min",
    "y = plain(x)": "calls plain; formulas call ti.max, ti.min",
    "y = endless(x)": "endless calls itself; a formula must not",
    "y = self.rest_pressure_ratio(x)": "calls self.rest_pressure_ratio; it must be a @ti.func of the class",
    "y = self.modulus * x": "names self.modulus; its class must have that constant or property",
    "y = unknown * x": "names unknown; it must be assigned before, or be a number of the file",
    "y = WORDS": "names WORDS; it must be assigned before, or be a number of the file",
    "y = stress[x]": "has stress[x]; only tuples have components, by a written number",
    "y = [x, x]": "has the expression [x, x]; formulas have numbers, names, tuples",
    "y = ti.max(x, b=x)": "calls ti.max(x, b=x); formulas are called with plain parameters",
    "y = 'text'": "has the value 'text'; formulas have numbers only",
    "self.kept = x": "changes self.kept; a formula must change names of its own only",
    "print(x)": "has the statement print(x); formulas have assignments and a return only",
    "if greatest(x) > 0.0:\n    y = 2.0 * x\nx = y": "names y; it must be assigned before",
    "return x": "stands behind a return; a formula must have one return, at its end",
}
KEPT = [  # what formulas may do
    "y = ti.select(x > TENTH, exp_minus(x), power(x, self.degree + 0.3))",
    "s = scaled(stress, -1.0)\nt = chosen(x > 0.0, s, stress)\nx = t[0] ** 2 + inner(s, t)",
    "if greatest(x) > 0.0:\n    y = 2.0 * x\n    x = ti.min(x, y)",
    "if ti.static(self.degree > 0.0):\n    x = 2.0 * x",
    "for k in ti.static(range(3)):\n    x = x + k * stress[0]",
    "a, b, c, d = scaled(stress, 2.0)\na = a + b",
]
OTHERS = {  # what is changed in the law: what is said of it
    ("@frozen\nclass", "class"): "Spring is no frozen dataclass; it must have @frozen",
    ("modulus_Pa: float = 1e6", "modulus_Pa: str = '1e6'"): "Spring.modulus_Pa is of type <class 'str'>; constants",
    ("    degree = 0.0\n", ""): "Spring has no degree; a law must have grain_density, rest_stress, degree",
    ("    grain_density: float = 2650.0\n", "    grain_density = 2650.0\n"): "Spring.grain_density is no constant",
    ("    @ti.func\n    def rate", "    def rate"): "Spring.rate is no formula; it must have @ti.func above it",
    ("def rate(self, stress, h,", "def rate(self, stress,"): "it must take self, stress, h, factors, D, d_bar",
    ("def rate(self, stress, h,", "def rate(self, stress, h: ti.f64,"): "the parameter h has a type; it must have none",
    ("    def stiffness", "    def stiff"): "Spring has no formula stiffness; it must have factors, advanced_factors,",
    ("return scaled(D, 2.0 * self.modulus_Pa)", "return trace(D)"): "Spring.rate returns a number; it must return a",
    ("return (0.0 * void_ratio,)", "return (1.0,)"): "returns the plain number 1.0; it must be 1.0 + 0.0 * a parameter",
    ("return (0.0 * void_ratio,)", "y = void_ratio"): "has no result; its last line must be a return",
    ("\nimport math", "\nfrom __future__ import annotations\nimport math"): "has `from __future__ import annotations`",
    ("REMEMBERS = False", "REMEMBERS = True"): "Spring has no radius; a law that remembers must have it",
    ("return 0.5", "return -0.5"): "Spring.rest_pressure_ratio is -0.5; it must be K0, between 0 and 10",
    ("0.0 * x + 2.0 * self", "0.0 * x + 1.0 * self"): "Spring.stiffness is 1e+06 Pa where a plane wave meets 2e+06 Pa",
    ("return scaled(D, 2.0 * self.modulus_Pa)", "return (D[0], 0.5 * D[1], D[2], D[3])"):
        "Spring.rate is another one where the axes x and y are turned",
    ("return scaled(D, 2.0 * self.modulus_Pa)", "return scaled(D, 1.0 / (d_bar - d_bar))"):
        "Spring.rate gives no number for a usual stress",
}  # fmt: skip


@pytest.fixture
def law(tmp_path, monkeypatch):
    """A function that writes a law into a file and returns its class."""

    def of(body="", change=("", "")):
        text = (HEAD + LAW).replace("        BODY\n", textwrap.indent(f"{body}\n" if body else "", 8 * " "))
        assert change[0] in text
        file = tmp_path / "law.py"
        file.write_text(text.replace(*change, 1) if change[0] else text)
        name = f"law_{abs(hash(body + str(change)))}"
        spec = importlib.util.spec_from_file_location(name, file)
        module = importlib.util.module_from_spec(spec)
        monkeypatch.setitem(sys.modules, name, module)
        spec.loader.exec_module(module)
        return module.Spring

    return of


def said(law):
    with pytest.raises(BadInput) as refused:
        own_parts.check_law(law)
    sentence = str(refused.value)
    assert "\n" not in sentence and "; " in sentence or "above it" in sentence
    return sentence


@pytest.mark.parametrize("body", BREACHES)
def test_a_breach_is_said_in_one_sentence_with_its_line(law, body, tmp_path):
    sentence = said(law(body))
    assert BREACHES[body] in sentence
    if not sentence.startswith("endless"):
        line = int(re.match(r"Spring.stiffness, line (\d+): ", sentence)[1])
        assert (tmp_path / "law.py").read_text().splitlines()[
            line - 1
        ].strip() in body + "return 0.0 * x + 2.0 * self.modulus_Pa"


@pytest.mark.parametrize("body", KEPT)
def test_what_keeps_the_rules_is_taken(law, body):
    own_parts.check_law(law(body))


@pytest.mark.filterwarnings("ignore:.*encountered in")
@pytest.mark.parametrize("change", OTHERS)
def test_a_law_that_is_not_one_is_said_in_one_sentence(law, change):
    assert OTHERS[change] in said(law(change=change))


@pytest.mark.parametrize("own", [GudehusBauer, Elastic, Coulomb, NoSlip, Frictionless, RoughFree])
def test_the_formulas_of_the_package_keep_the_rules(own):
    (own_parts.check_contact if hasattr(own, "touch") else own_parts.check_law)(own)


def test_those_of_the_law_with_memory_keep_them_too():
    own_parts._formulas(Intergranular, own_parts.OF_A_LAW | own_parts.OF_A_MEMORY)


def test_names_and_parts_that_cannot_be_registered_are_refused(law):
    for name, part, words in (
        ("intergranular", law(), "name is intergranular; a law of the package has it"),
        ("Spring", law(), "name is Spring; it must begin with a small letter"),
        ("spring", law, "part is of; it must be the class of a law"),
    ):
        with pytest.raises(BadInput, match=words):
            register(name, part)


def test_a_file_that_cannot_be_run_is_refused(tmp_path):
    for name, text, words in (
        ("gone.py", None, "it must be a Python file, such as my_law.py, and be there"),
        ("law.toml", "", "it must be a Python file"),
        ("broken.py", "1 / 0", "cannot be run: ZeroDivisionError: division by zero"),
    ):
        if text is not None:
            (tmp_path / name).write_text(text)
        with pytest.raises(BadInput, match=words):
            load_plugin(tmp_path / name)
    assert not [file for file in plugin_files.loaded() if "broken" in file]
