"""The link to one instrument, opened anew when its port went away and came back."""

import contextlib
import time

from arcref.input_error import InputError
from arcref.instrument.register_access import RegisterAccess
from arcref.instrument_error import InstrumentError
from arcref.link.link import Link, LinkLost
from arcref.link.port_finder import open_link

RETRY_S = 0.2
"""Pause between two attempts to open a port that went away."""

SAME_INSTRUMENT = ("gateware", "rom_crc32")
"""Registers by which it is told from another that was plugged in instead."""


class KeptLink:
    """An open link under the name of its port.

    `interruptions`: times that the port went away and was opened again. Raises as `open_link` does.
    """

    def __init__(self, port: str | None, baud: int, on_record):
        self._baud, self._on_record = baud, on_record
        self._take(open_link(port, baud=baud, on_record=on_record))
        self.name = self._link.name
        self.interruptions = 0
        self._closed = False
        self.recognise()

    @property
    def lost(self) -> bool:
        """True while the port is gone."""
        return self._link.lost

    @property
    def link(self) -> Link:
        """The link as it is; when the port went away, it is tried once whether it is back."""
        if self.lost and not self._closed:
            with contextlib.suppress(InputError, InstrumentError):  # the request then says that the port is gone
                self.reopen(0.0)
        return self._link

    @property
    def registers(self) -> RegisterAccess:
        """The registers behind `link`."""
        _ = self.link  # which opens it anew where need be
        return self._registers

    def reopen(self, wait_s: float) -> None:
        """Open the port again when it comes back.

        Raises `LinkLost` when it does not within `wait_s`, or when another instrument, or another ROM, is there.
        """
        self._link.release()
        deadline = time.monotonic() + wait_s
        while True:
            try:
                link = open_link(self.name, baud=self._baud, on_record=self._on_record)
                break
            except (InputError, InstrumentError) as error:
                if time.monotonic() >= deadline:
                    waited = f" and did not come back in {wait_s:g} s" if wait_s else ""
                    raise LinkLost(f"{self.name} went away{waited}") from error
            time.sleep(RETRY_S)
        lost = self._link
        self._take(link)
        if self._who() != self._is:
            self._take(lost)
            link.close()
            raise LinkLost(f"another instrument, or another ROM, is at {self.name} now")
        self.interruptions += 1

    def close(self) -> None:
        """Close the port."""
        self._closed = True
        self._link.close()

    def recognise(self) -> None:
        """Take what is there now, gateware and ROM, for the instrument that must come back."""
        self._is = self._who()

    def _take(self, link: Link) -> None:
        self._link, self._registers = link, RegisterAccess(link)

    def _who(self) -> dict[str, int]:
        return self._registers.read_together(SAME_INSTRUMENT)
