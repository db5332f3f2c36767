"""A bad cable: bytes that change, get lost or come twice on their way."""

import random
from collections.abc import Callable


def noisy_wire(seed: int, per_byte: float) -> Callable[[bytes], bytes]:
    """A channel that has a bit of a byte wrong, drops it or doubles it, each as often, `per_byte` in all."""
    rng = random.Random(seed)

    def noisy(data: bytes) -> bytes:
        out = bytearray()
        for byte in data:
            if rng.random() >= per_byte:
                out.append(byte)
                continue
            what = rng.randrange(3)
            if what == 0:
                out.append(byte ^ (1 << rng.randrange(8)))
            elif what == 1:
                out += bytes([byte, byte])
        return bytes(out)

    return noisy
