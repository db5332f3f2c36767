"""The manual's tables, those of the host and the ports of the core. Run as a module to write them into pages."""

import sys

from arcref.manual_tables import HOST_TABLES, fill_pages, markdown_table
from arcref_gateware.core_ports import CORE_PORTS


def port_table() -> str:
    """The ports of `arcref_core`."""
    rows = [
        [f"`{port.name}`", "in" if port.direction == "input" else "out", str(port.width or "N"), port.meaning]
        for port in CORE_PORTS
    ]
    return markdown_table(["port", "direction", "bits", "meaning"], rows)


TABLES = HOST_TABLES | {"ports": port_table()}
"""Every table a page may ask for."""

if __name__ == "__main__":
    fill_pages(sys.argv[1:], TABLES)
