"""The method is a library: the script of its page runs without anything of silos, and finds what mechanics says."""

import re
import subprocess
import sys

import pytest
from written import blocks

from taichi_silo import mpm

ENDING = """
import sys
own = "taichi_silo.mpm", "taichi_silo.errors"
foreign = [name for name in sys.modules if name.startswith("taichi_silo.") and not name.startswith(own)]
print("foreign", foreign)
"""


def test_the_script_of_the_page_slides_a_block_with_g_sin_minus_mu_cos_and_needs_no_silo(tmp_path):
    (block,) = (block for block in blocks("python") if block.page == "how-to/mpm.md")
    script = tmp_path / "block.py"
    script.write_text(block.text + ENDING)
    done = subprocess.run([sys.executable, str(script)], capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr[-2000:]
    acceleration, exact = map(float, re.search(r"a = ([\d.]+) m/s2, exactly ([\d.]+)", done.stdout).groups())
    assert exact == pytest.approx(1.813, abs=0.001)
    assert acceleration == pytest.approx(exact, rel=0.01)
    assert "foreign []" in done.stdout


def test_every_public_name_is_there():
    assert all(getattr(mpm, name) is not None for name in mpm.__all__)
    with pytest.raises(AttributeError, match="Silo"):
        mpm.Silo  # noqa: B018
