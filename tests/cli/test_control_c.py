"""Ctrl-C at places where Python and CasADi drop an exception."""

from __future__ import annotations

import copy
import signal
import weakref

import casadi as ca
import pytest

from fowtlib.cli.control_c import heard

pytestmark = pytest.mark.usefixtures("python_handler")


class Converted:
    """CasADi asks it for an expression."""

    def __SX__(self):
        signal.raise_signal(signal.SIGINT)
        return ca.SX(4.0)


class ThrownAway:
    def __del__(self):
        self.press()

    def press(self):
        signal.raise_signal(signal.SIGINT)


def converted(done: list[str]) -> None:
    ca.sqrt(Converted())
    done.append("next line")


def one_of_many(done: list[str]) -> None:
    [ca.sqrt(Converted()) + k for k in range(3)]
    done.append("next line")


def thrown_away(done: list[str]) -> None:
    one = ThrownAway()
    del one
    done.append("next line")


def forgotten(done: list[str]) -> None:
    known = weakref.WeakValueDictionary(a=(one := ThrownAway()))
    del one
    done.append(f"{len(known)} left")


class KeepsNothing(type):
    def __setattr__(cls, name, value):
        signal.raise_signal(signal.SIGINT)
        super().__setattr__(name, value)


def copied(done: list[str]) -> None:
    copy.deepcopy(KeepsNothing("Copied", (), {})())
    done.append("next line")


def plainly(done: list[str]) -> None:
    signal.raise_signal(signal.SIGINT)
    done.append("next line")


@pytest.mark.parametrize("work", [converted, one_of_many, thrown_away, forgotten, copied, plainly])
def test_it_gets_to_the_one_who_waits_for_it(work):
    done: list[str] = []
    with pytest.raises(KeyboardInterrupt), heard():
        work(done)
    assert not done


def test_without_it_casadi_makes_another_error_of_it():
    """What all this is for; should CasADi pass exceptions on one day, it can go."""
    with pytest.raises(NotImplementedError, match="Wrong number or type of arguments"):
        converted([])


def test_another_handler_stays():
    asked = []
    signal.signal(signal.SIGINT, lambda *_: asked.append(1))
    with heard():
        signal.raise_signal(signal.SIGINT)
    assert asked == [1]


def test_what_is_given_back_is_what_was_there():
    with heard():
        assert signal.getsignal(signal.SIGINT) is not signal.default_int_handler
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
