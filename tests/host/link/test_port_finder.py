"""Finding the instrument's port when none was named."""

import os
from types import SimpleNamespace

import pytest
from pseudo_instrument import PseudoInstrument

from arcref import Encoder, InputError
from arcref.link import link, port_finder

ADAPTER = next(iter(port_finder.BOARD_ADAPTERS))


@pytest.fixture
def plugged_in(monkeypatch):
    """Says which ports the system lists: `plugged_in(port, ...)`, each behind an adapter of a board."""
    monkeypatch.delenv(port_finder.PORT_VARIABLE, raising=False)
    monkeypatch.setattr(link, "ANSWER_TIMEOUT_S", 0.05)

    def say(*ports, adapter=ADAPTER):
        listed = [SimpleNamespace(device=port, vid=adapter[0], pid=adapter[1]) for port in ports]
        monkeypatch.setattr(port_finder.list_ports, "comports", lambda: listed)

    return say


@pytest.fixture
def silent_port():
    near, far = os.openpty()
    yield os.ttyname(far)
    os.close(near)
    os.close(far)


def test_the_only_instrument_is_found_beside_a_port_that_is_silent(plugged_in, silent_port):
    with PseudoInstrument() as instrument:
        plugged_in(silent_port, instrument.port)
        with Encoder() as encoder:
            assert encoder.port == instrument.port


def test_two_instruments_are_not_chosen_between(plugged_in):
    with PseudoInstrument() as one, PseudoInstrument() as other:
        plugged_in(one.port, other.port)
        with pytest.raises(InputError, match=f"2 instruments are plugged in \\({one.port}, {other.port}\\): name one"):
            Encoder()


def test_why_no_port_serves_is_told_of_each(plugged_in, silent_port):
    with PseudoInstrument() as used, PseudoInstrument({"protocol": 0}) as old, Encoder(used.port):
        plugged_in(used.port, old.port, silent_port)
        with pytest.raises(InputError) as error:
            Encoder()
    for problem in (
        f"{used.port}: busy: another program has it open",
        f"{old.port}: the instrument speaks protocol 0, older than",
        f"{silent_port}: nothing there answers as an arcref instrument does",
    ):
        assert problem in str(error.value)


def test_a_port_of_another_adapter_is_left_alone(plugged_in):
    with PseudoInstrument() as instrument:
        plugged_in(instrument.port, adapter=(0x1234, 1))
        with pytest.raises(InputError, match="no instrument was found: plug one in"):
            Encoder()


def test_the_environment_names_the_port(plugged_in, monkeypatch):
    with PseudoInstrument() as instrument, PseudoInstrument() as other:
        plugged_in(instrument.port, other.port)
        monkeypatch.setenv(port_finder.PORT_VARIABLE, other.port)
        with Encoder() as encoder:
            assert encoder.port == other.port
