"""A drawing of what is wired to which pin, as SVG, made from the board's file."""

from html import escape

from arcref_gateware.boards.board import ALIGNMENT, Board, BoardPin

SOURCES = (
    ("interpolator", ("a", "b", "z"), "square waves and zero pulse"),
    ("test bench", ("strobe",), "rising edge captures"),
    ("controller", ("spi_sck", "spi_cs_n", "spi_copi", "spi_cipo"), "SPI, mode 0"),
    ("host computer", ("uart_rx", "uart_tx"), "serial link"),
    ("whatever you trigger", ("compare",), "a pulse every so many counts"),
    ("nothing", (ALIGNMENT,), "checks the samplers: leave it open"),
)
"""What stands on the left: name, its signals, what they are."""

SIGNAL_NAMES = {
    "a": "A",
    "b": "B",
    "z": "Z",
    "strobe": "strobe",
    "spi_sck": "SCK",
    "spi_cs_n": "CS, active low",
    "spi_copi": "COPI",
    "spi_cipo": "CIPO",
    "uart_rx": "UART, from the host",
    "uart_tx": "UART, to the host",
    "compare": "compare",
    ALIGNMENT: "alignment",
}

ROW, GAP, HEAD, MARGIN = 26, 22, 34, 16
LEFT, LEFT_WIDTH, RIGHT, RIGHT_WIDTH = 16, 230, 400, 400
WIDTH = RIGHT + RIGHT_WIDTH + MARGIN

STYLE = (
    "text{font:14px system-ui,sans-serif;fill:#1a1a1a}.head{font-weight:600}.small{font-size:12px;fill:#555}"
    ".box{fill:#f4f6f8;stroke:#5a6673}.board{fill:#e9f3ec;stroke:#2f6b45}.wire{stroke:#1f5fa8;stroke-width:2}"
    ".pin{fill:#1f5fa8}.open{fill:#fff;stroke:#8a8a8a;stroke-width:2}"
)


def wiring_drawing(board: Board) -> str:
    """The drawing. The same board gives the same text."""
    wires, boxes = [], []
    y = MARGIN + HEAD
    for source, signals, meaning in SOURCES:
        pins = [board.pins[signal] for signal in signals if signal in board.pins]
        if not pins:
            continue
        height = HEAD + 6 + ROW * len(pins)
        boxes.append(f'<rect class="box" x="{LEFT}" y="{y}" width="{LEFT_WIDTH}" height="{height}" rx="6"/>')
        boxes.append(_text(LEFT + 10, y + 17, source, "head"))
        boxes.append(_text(LEFT + 10, y + 32, meaning, "small"))
        for row, pin in enumerate(pins):
            wires += _wire(pin, y + HEAD + 6 + ROW * row + ROW // 2 - 2)
        y += height + GAP
    height = y - GAP + MARGIN
    board_height = height - 2 * MARGIN
    head = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" width="{WIDTH}" height="{height}" '
        f'role="img" aria-label="{escape(f"Wiring of {board.title}")}">',
        f"<style>{STYLE}</style>",
        f'<rect width="{WIDTH}" height="{height}" fill="#fff"/>',
        f'<rect class="board" x="{RIGHT}" y="{MARGIN}" width="{RIGHT_WIDTH}" height="{board_height}" rx="6"/>',
        _text(RIGHT + 14, MARGIN + 21, board.title, "head"),
        _text(LEFT, MARGIN + 14, "Join the grounds of all of these.", "small"),
    ]
    return "\n".join([*head, *boxes, *wires, "</svg>"]) + "\n"


def _wire(pin: BoardPin, y: int) -> list[str]:
    name = SIGNAL_NAMES[pin.signal] + (" (a pair)" if pin.differential else "")
    start, end = LEFT + LEFT_WIDTH, RIGHT
    parts = []
    if pin.signal == ALIGNMENT:
        parts.append(f'<circle class="open" cx="{end}" cy="{y}" r="5"/>')
    else:
        for offset in (-3, 3) if pin.differential else (0,):
            parts.append(f'<line class="wire" x1="{start}" y1="{y + offset}" x2="{end}" y2="{y + offset}"/>')
        # The arrow points to whoever listens.
        tip, back = (end - 4, end - 14) if pin.direction == "i" else (start + 4, start + 14)
        parts.append(f'<polygon class="pin" points="{tip},{y} {back},{y - 5} {back},{y + 5}"/>')
    parts.append(f'<text x="{start - 12}" y="{y + 5}" text-anchor="end">{escape(name)}</text>')
    details = [f"ball {' '.join(pin.balls)}", pin.io_standard]
    if pin.pull != "none":
        details.append(f"pull {pin.pull}")
    if pin.termination_ohm:
        details.append(f"{pin.termination_ohm} ohm")
    if pin.inverted:
        details.append("inverted")
    parts.append(_text(end + 14, y + 5, pin.label or " ".join(pin.names)))
    parts.append(
        f'<text class="small" x="{end + RIGHT_WIDTH - 12}" y="{y + 5}" text-anchor="end">'
        f"{escape(', '.join(details))}</text>"
    )
    return parts


def _text(x: int, y: int, text: str, kind: str = "") -> str:
    attribute = f' class="{kind}"' if kind else ""
    return f'<text{attribute} x="{x}" y="{y}">{escape(text)}</text>'
