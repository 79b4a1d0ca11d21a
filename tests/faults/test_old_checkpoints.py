"""A checkpoint that an older version wrote is refused in a sentence; nothing of the run is touched."""

import re
import shutil

import pytest

from taichi_silo.errors import BadInput
from taichi_silo.runs.session import resume
from taichi_silo.utils import checked_npz


@pytest.mark.parametrize("number", [1])
def test_a_checkpoint_of_an_older_version_is_refused_clearly(tmp_path, data, tried, number):
    """`checkpoint_format_1.npz` was written by the version that had it."""
    shutil.copy(data / f"checkpoint_format_{number}.npz", tmp_path / "checkpoint.npz")
    whole = (tmp_path / "checkpoint.npz").read_bytes()
    words = rf"is of format {number}; this version of taichi-silo goes on from format {checked_npz.FORMAT}"
    with pytest.raises(BadInput, match=re.escape(words)):
        resume(tmp_path)
    assert [file.name for file in tmp_path.iterdir()] == ["checkpoint.npz"]
    assert (tmp_path / "checkpoint.npz").read_bytes() == whole
    tried("faults survived", "checkpoint of an older version")
