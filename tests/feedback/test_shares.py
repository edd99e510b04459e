"""The sweep over interval ends, against counting."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from symrt.feedback.shares import End, Piece, curve, pieces, shared
from symrt.gamut.looking import Spans

TICK = st.integers(0, 8)


@st.composite
def many_spans(draw):
    """Up to three separate closed intervals for each of a few pixels, with whole numbers as ends."""
    found = []
    for pixel in range(draw(st.integers(0, 5))):
        ends = sorted(draw(st.lists(TICK, min_size=2, max_size=6, unique=True)))
        found += [(pixel, low, high) for low, high in zip(ends[::2], ends[1::2], strict=False)]
    pixel, low, high = np.array(found, dtype=float).reshape(-1, 3).T
    return Spans(pixel.astype(int), low, high)


def inside(spans, t):
    return len(set(spans.pixel[(spans.low <= t) & (t <= spans.high)].tolist()))


@given(many_spans(), st.integers(0, 6))
def test_pieces_hold_exactly_where_enough_pixels_are_inside(spans, needed):
    found = pieces(spans, (0, 8), needed, "upper")
    for t in np.arange(0, 8.25, 0.25):
        held = any(piece.low <= t <= piece.high for piece in found)
        assert held == (inside(spans, t) >= needed)


@given(many_spans(), st.integers(1, 6))
def test_the_pixel_named_at_an_end_has_an_interval_that_ends_there(spans, needed):
    for piece in pieces(spans, (0, 8), needed, "upper"):
        for t, end, column in ((piece.low, piece.below, spans.low), (piece.high, piece.above, spans.high)):
            if end.kind == "range":
                assert t in (0, 8)
            else:
                assert t in column[spans.pixel == end.pixel]


@given(many_spans(), many_spans())
def test_shared_pieces_are_in_both_lists(one, other):
    first, second = (pieces(s, (0, 8), 1, "upper") for s in (one, other))
    found = shared(first, second)
    for t in np.arange(0, 8.25, 0.25):
        both = all(any(p.low <= t <= p.high for p in side) for side in (first, second))
        assert both == any(p.low <= t <= p.high for p in found)


@given(many_spans())
def test_the_curve_counts_what_is_outside(spans):
    t = np.arange(0, 8.25, 0.25)
    expected = [1 - (inside(spans, v) + 2) / 10 for v in t]
    np.testing.assert_allclose(curve(spans, always=2, pixels=10).outside(t), expected, atol=1e-15)


def test_values_of_the_curve_are_where_it_changes():
    spans = Spans(np.array([0, 1]), np.array([0.0, 0.5]), np.array([1.0, 1.0]))
    assert curve(spans, 0, 2).values.tolist() == [0.0, 0.5, 1.0]


def test_no_pixels_leave_the_whole_range():
    none = Spans(np.zeros(0, dtype=int), np.zeros(0), np.zeros(0))
    assert pieces(none, (0.5, 2), 0, "upper") == [Piece(0.5, 2.0, End("range"), End("range"))]
    assert pieces(none, (0.5, 2), 1, "upper") == []


@pytest.mark.parametrize("needed", [1, 2, 3])
def test_touching_intervals_share_their_end(needed):
    spans = Spans(np.arange(3), np.array([0.0, 1.0, 1.0]), np.array([1.0, 1.0, 2.0]))
    low, high = {1: (0.0, 2.0), 2: (1.0, 1.0), 3: (1.0, 1.0)}[needed]
    assert [(p.low, p.high) for p in pieces(spans, (0, 2), needed, "upper")] == [(low, high)]
