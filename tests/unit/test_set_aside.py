"""Arrays that wait on the disk come back bit by bit, also by way of another file."""

import numpy as np

from taichi_silo.utils import checked_npz
from taichi_silo.utils.set_aside import SetAside

PLACES = np.random.default_rng(1).normal(size=(100, 2))
STATE = {
    "position": PLACES, "reversed": PLACES[::-1, 1], "identity": np.arange(100, dtype=np.int32), "none": PLACES[:0],
    "time_s": 0.1,
}  # fmt: skip


def test_what_is_set_aside_comes_back_in_the_same_order_and_leaves_nothing_in_the_folder(tmp_path):
    aside = SetAside(tmp_path, STATE)
    assert list(tmp_path.iterdir()) == []
    for _ in range(2):
        found = aside.read()
        assert set(found) == set(STATE) and found["time_s"] == 0.1
        for name, values in STATE.items():
            if isinstance(values, np.ndarray):
                assert found[name].dtype == values.dtype and np.array_equal(found[name], values), name


def test_some_arrays_come_back_with_all_that_is_no_array():
    assert set(SetAside(None, STATE).read("identity", "none")) == {"identity", "none", "time_s"}


def test_what_is_set_aside_can_be_set_aside_again_and_written_into_a_checkpoint(tmp_path):
    aside = SetAside(tmp_path, STATE)
    checked_npz.write(tmp_path / "one.npz", {"kept": aside.kept})
    again = SetAside(None, aside.kept).read()
    read = checked_npz.read(tmp_path / "one.npz")[1]["kept"]
    for found in (again, read):
        assert found["time_s"] == 0.1
        for name in set(STATE) - {"time_s"}:
            assert np.array_equal(found[name], STATE[name]), name
