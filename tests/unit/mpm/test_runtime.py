"""One Taichi after the other in one process."""

import gc

import pytest

from taichi_silo.mpm import graphics_cards, runtime
from taichi_silo.mpm.graphics_cards import Card
from taichi_silo.mpm.language import NAME, ti


@ti.kernel
def total(values: ti.types.ndarray(dtype=ti.f64, ndim=1)) -> ti.f64:
    found = 0.0
    for i in values:
        values[i] = 1.0
        found += values[i]
    return found


def test_arrays_of_an_ended_taichi_take_nothing_from_the_next():
    """With arrays of Taichi's own, some of two hundred lie where old ones lay, and go with them."""
    runtime.init()
    old = [runtime.array(ti.f64, 1000 + number) for number in range(200)]
    runtime.init()
    new = [runtime.array(ti.f64, 50) for _ in range(200)]
    del old
    gc.collect()
    assert [total(one) for one in new] == [50.0] * 200


CARD, SLOW = Card(1, "Card", "discrete card", True, 999), Card(0, "lavapipe", "software driver", True, 32)
SINGLE = Card(2, "Phone", "integrated card", False, 16)


@pytest.mark.skipif(graphics_cards.chosen(graphics_cards.vulkan_cards()) is None, reason="no Vulkan device with f64")
@pytest.mark.parametrize("apart", [True, False])
def test_whole_numbers_lie_apart_from_others_on_vulkan(apart):
    """In one tree with f64 an odd number of them lies under these in Taichi, no longer in its fork."""
    runtime.init("vulkan")
    whole = runtime.whole_numbers((3,))[0] if apart else ti.field(ti.i32, shape=3)
    other = ti.field(ti.f64, shape=4)
    whole.fill(1)
    other.fill(2.0)
    assert ((whole.to_numpy() == 1).all() and (other.to_numpy() == 2.0).all()) == (apart or NAME == "quadrants")
    runtime.init()


@pytest.mark.parametrize(
    ("there", "asked", "taken"),
    [
        ([SLOW], "", SLOW), ([CARD, SLOW], "", CARD), ([CARD, SLOW], "0", SLOW), ([SINGLE, SLOW], "", SLOW),
        ([SINGLE], "", None), ([CARD, SINGLE], "2", None), ([], "", None),
    ],
)  # fmt: skip
def test_vulkan_takes_the_fastest_card_that_computes_in_f64_or_the_one_that_is_asked_for(
    there, asked, taken, monkeypatch
):
    monkeypatch.setenv(graphics_cards.CHOICE, asked)
    assert graphics_cards.chosen(there) == taken


@pytest.mark.parametrize(
    ("there", "words"),
    [([], "no Vulkan device answers; install"), ([SINGLE], r"Phone computes in f32 only \(no shaderFloat64\)")],
)
def test_a_card_that_cannot_be_used_is_told_in_a_sentence(there, words, monkeypatch):
    monkeypatch.delenv(graphics_cards.CHOICE, raising=False)
    monkeypatch.setattr(graphics_cards, "vulkan_cards", lambda: there)
    with pytest.raises(runtime.ArchitectureError, match=words):
        runtime.init("vulkan")
