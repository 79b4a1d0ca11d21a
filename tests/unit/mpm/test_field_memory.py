"""A field of a processor is read and written where it lies, as Taichi would read and write it."""

import numpy as np
import pytest

from taichi_silo.mpm import field_memory, runtime
from taichi_silo.mpm.language import NAME, ti

in_place = pytest.mark.skipif(NAME != "taichi", reason="its fork does not say where a field lies")


def fields():
    """Fields as the package places them: alone, in records, in trees of their own."""
    place, mass = ti.Vector.field(2, ti.f64), ti.field(ti.f64)
    ti.root.dense(ti.i, 7).place(place, mass)
    several = ti.field(ti.f64, shape=(3, 5)), ti.field(ti.f64, shape=(2, 3, 2)), ti.field(ti.i32, shape=3)
    vectors = ti.Vector.field(4, ti.f64, shape=9), ti.Vector.field(2, ti.f64, shape=(3, 4))
    return [place, mass, *several, *vectors, *runtime.whole_numbers((4, 5), (3,), (2, 6))]


def numbers(field):
    """Numbers of the field's shape and kind."""
    kind = ti.lang.util.to_numpy_type(field.dtype)
    return (1000.0 * np.random.default_rng(1).random(field.to_numpy().shape)).astype(kind)


@in_place
def test_what_is_written_in_place_is_what_taichi_reads():
    for field in fields():
        assert field_memory.view(field) is not None
        field_memory.put(field, numbers(field))
        assert (field.to_numpy() == numbers(field)).all()


@in_place
def test_what_taichi_writes_is_what_is_read_in_place():
    for field in fields():
        field.from_numpy(numbers(field))
        assert (field_memory.values(field) == numbers(field)).all()


@pytest.mark.parametrize("elsewhere", [False, True])
def test_first_entries_are_set_and_the_others_are_0(monkeypatch, elsewhere):
    if elsewhere:
        monkeypatch.setattr(field_memory, "view", lambda field: None)
    for field in fields():
        field_memory.put(field, 1)
        field_memory.put(field, numbers(field)[:2], 2)
        assert (field_memory.values(field, 2) == numbers(field)[:2]).all()
        assert not field.to_numpy()[2:].any()


def test_what_was_read_does_not_change_with_the_field():
    field = ti.field(ti.f64, shape=3)
    before = field_memory.values(field)
    field_memory.put(field, 2.0)
    assert not before.any()
    assert (field_memory.values(field) == 2.0).all()


def test_a_single_number_is_read_and_written():
    count = runtime.whole_numbers(())[0]
    field_memory.put(count, 5)
    assert count[None] == 5
    count[None] = 6
    assert field_memory.values(count) == 6


def test_fields_of_a_taichi_that_is_started_anew_lie_where_that_has_put_them():
    for number in (1.0, 2.0):
        runtime.init()
        field = ti.field(ti.f64, shape=1000)
        field_memory.put(field, number)
        assert (field.to_numpy() == number).all()
