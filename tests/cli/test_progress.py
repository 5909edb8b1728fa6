"""Ctrl-C during a simulation waits until the solver reports."""

from __future__ import annotations

import signal

import pytest

from fowtlib.cli.progress import progress_bar


@pytest.fixture(autouse=True)
def python_handler():
    """The handler of an interactive start; a test run in the background may have been started without."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def test_control_c_is_kept_until_the_next_report():
    before = signal.getsignal(signal.SIGINT)
    with pytest.raises(KeyboardInterrupt), progress_bar() as report:
        report(0.0, 10.0)
        signal.raise_signal(signal.SIGINT)  # as if inside compiled code: nothing happens yet
        report(5.0, 10.0)
    assert signal.getsignal(signal.SIGINT) is before


def test_a_second_control_c_acts_at_once():
    with pytest.raises(KeyboardInterrupt), progress_bar():
        signal.raise_signal(signal.SIGINT)
        signal.raise_signal(signal.SIGINT)
        pytest.fail("still running")
