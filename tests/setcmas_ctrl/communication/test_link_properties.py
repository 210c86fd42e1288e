import numpy as np
import pytest

from setcmas_ctrl.communication.link_properties import (
    happens,
    normal,
    streams_of,
    thresholds,
    word,
)

N = 40_000
NUMBERS = np.arange(N)


def test_words_are_those_of_splitmix64():
    stream = np.array([1234567], dtype=np.uint64)

    # The first outputs for this seed, as published beside the reference implementation.
    words = word(stream, np.array([1, 2, 3]))
    assert words.tolist() == [6457827717110365317, 3203168211198807973, 9817491932198370423]


@pytest.mark.parametrize('varied', ['seed', 'receiver', 'sender', 'times_up', 'number'])
def test_draws_are_uniform_and_uncorrelated_between_messages(varied):
    what = dict.fromkeys(('seed', 'receiver', 'sender', 'times_up'), 3) | {'number': 0}
    what[varied] = NUMBERS
    number = what.pop('number')
    words = word(streams_of(*what.values()), np.atleast_1d(number))
    u = words / 2.0**64

    counts, _ = np.histogram(u, bins=64, range=(0, 1))
    chi_square = ((counts - N / 64) ** 2 / (N / 64)).sum()
    assert 20 < chi_square < 130  # 63 degrees of freedom
    for lag in (1, 2, 3, 8):
        assert abs(np.corrcoef(u[:-lag], u[lag:])[0, 1]) < 5 / np.sqrt(N)
    bits = words[:, None] >> np.arange(64, dtype=np.uint64) & np.uint64(1)
    assert (np.abs(bits.mean(axis=0) - 0.5) < 2.5 / np.sqrt(N)).all()


def test_streams_differ_although_their_numbers_are_exchanged():
    streams = [int(streams_of(*parts)[0]) for parts in ((1, 2), (2, 1), (0, 3), (3, 0), (3,))]

    assert len(set(streams)) == 5


def test_an_event_happens_as_often_as_its_probability_says():
    words = word(streams_of(7), NUMBERS)

    for probability in (0.0, 0.01, 0.5, 1.0):
        ratio = happens(words, thresholds(np.array(probability))).mean()
        spread = np.sqrt(probability * (1 - probability) / N)
        assert abs(ratio - probability) <= 5 * spread


def test_normal_numbers_are_normal_and_independent():
    stream = streams_of(7)
    numbers = normal(word(stream, 2 * NUMBERS + np.array([[0], [1]])))
    counts, _ = np.histogram(numbers, bins=[-np.inf, -2, -1, 0, 1, 2, np.inf])

    expected = 2 * N * np.array([0.02275, 0.13591, 0.34134, 0.34134, 0.13591, 0.02275])
    assert ((counts - expected) ** 2 / expected).sum() < 25  # 5 degrees of freedom
    assert abs(np.corrcoef(numbers)[0, 1]) < 5 / np.sqrt(N)
    extreme = np.array([[0, 2**64 - 1], [0, 2**64 - 1]], dtype=np.uint64)
    assert np.isfinite(normal(extreme)).all()
