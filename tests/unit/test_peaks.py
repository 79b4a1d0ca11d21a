"""Peaks of a profile are those that the signal library finds."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import find_peaks

from taichi_silo.analysis.measure.peaks import peaks

LEVELS = st.integers(-5, 5).map(float)  # few, so that level stretches come up


@settings(max_examples=300, deadline=None)
@given(profile=st.lists(LEVELS, max_size=40), height=LEVELS, prominence=st.integers(0, 8).map(float))
def test_peaks_are_those_of_the_signal_library(profile, height, prominence):
    profile = np.array(profile)
    assert (
        peaks(profile, height, prominence).tolist()
        == find_peaks(profile, height=height, prominence=prominence)[0].tolist()
    )
