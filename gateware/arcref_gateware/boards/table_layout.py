"""Where the words of the three tables lie in a bitstream: found once from the placeholder, used for every ROM after.

Each bit of each table is cut into columns of consecutive words. In a bitstream built with the placeholder contents
every column can be told from every other, so each is looked for among the columns of all block RAMs. The layout that
comes out is a property of the placement and holds whatever contents the block RAMs get later.
"""

from dataclasses import dataclass

import numpy as np

from arcref_gateware.boards.block_ram_image import BlockRamImage, Place
from arcref_gateware.table_contents import TableContents

WORD_BITS = 16


class TablesNotFound(ValueError):
    """The tables are not where they should be. The text says which words are missing."""


@dataclass(frozen=True)
class TableLayout:
    """The place of each column: `places[memory][part][bit]` holds bit `bit` of the `part`-th run of words."""

    places: dict[str, list[list[Place]]]

    def to_json(self) -> dict:
        """Lists and numbers for JSON."""
        return {memory: [[list(place) for place in part] for part in parts] for memory, parts in self.places.items()}

    @classmethod
    def from_json(cls, value) -> "TableLayout":
        """The layout that `to_json` gave. Raises `ValueError` for anything else."""
        try:
            places = {
                memory: [[tuple(map(int, place)) for place in part] for part in value[memory]]
                for memory in TableContents._fields
            }
        except (TypeError, KeyError, ValueError):
            raise ValueError("the places of the tables cannot be read") from None
        if any(len(part) != WORD_BITS for parts in places.values() for part in parts):
            raise ValueError(f"a part of a table has other than {WORD_BITS} places")
        return cls(places)


def find_tables(image: BlockRamImage, contents: TableContents) -> TableLayout:
    """Where `contents`, the placeholder, lie in `image`.

    Raises `TablesNotFound` when a column is missing or there twice.
    """
    wanted = {
        column.tobytes(): (memory, part, bit)
        for memory, words in contents._asdict().items()
        for (part, bit), column in _columns(words, image.geometry.column_words)
    }
    found: dict[tuple, Place] = {}
    for place, indices in image.columns():
        key = wanted.get(image.bits[indices].tobytes())
        if key is None:
            continue
        if key in found:
            raise TablesNotFound(f"bit {key[2]} of the {key[0]} table lies in two places, {found[key]} and {place}")
        found[key] = place
    missing = sorted(set(wanted.values()) - set(found))
    if missing:
        memory, part, bit = missing[0]
        words = f"{part * image.geometry.column_words} .. {(part + 1) * image.geometry.column_words - 1}"
        problem = f"{len(missing)} of {len(wanted)} columns were not found, the first is bit {bit} of {memory} {words}"
        raise TablesNotFound(problem)
    parts = {memory: len(words) // image.geometry.column_words for memory, words in contents._asdict().items()}
    places = {
        memory: [[found[memory, part, bit] for bit in range(WORD_BITS)] for part in range(parts[memory])]
        for memory in TableContents._fields
    }
    return TableLayout(places)


def read_tables(image: BlockRamImage, layout: TableLayout) -> TableContents:
    """The words that lie in the places of `layout`. Raises `TablesNotFound` when `image` has no such place."""
    return TableContents(
        *(np.concatenate([_words(image, part) for part in layout.places[memory]]) for memory in TableContents._fields)
    )


def place_tables(image: BlockRamImage, layout: TableLayout, contents: TableContents) -> np.ndarray:
    """The bits of `image` with `contents` in the places of `layout`; everything else as it is."""
    bits = image.bits.copy()
    for memory, words in contents._asdict().items():
        parts = layout.places[memory]
        if len(words) != len(parts) * image.geometry.column_words:
            have = len(parts) * image.geometry.column_words
            raise TablesNotFound(f"the {memory} table has {len(words)} words, there is room for {have}")
        for (part, bit), column in _columns(words, image.geometry.column_words):
            bits[_indices(image, parts[part][bit])] = column
    return bits


def _columns(words, column_words: int):
    """Each column of a table, uint8, with its part and its bit."""
    words = np.asarray(words)
    for part in range(len(words) // column_words):
        run = words[part * column_words : (part + 1) * column_words]
        for bit in range(WORD_BITS):
            yield (part, bit), (run >> bit & 1).astype(np.uint8)


def _words(image: BlockRamImage, places: list[Place]) -> np.ndarray:
    words = np.zeros(image.geometry.column_words, np.uint16)
    for bit, place in enumerate(places):
        words |= image.bits[_indices(image, place)].astype(np.uint16) << bit
    return words


def _indices(image: BlockRamImage, place: Place) -> np.ndarray:
    try:
        return image.column(place)
    except (KeyError, ValueError):
        raise TablesNotFound(f"there is no block RAM at {place}") from None
