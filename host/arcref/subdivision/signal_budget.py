"""What each fault of the signals does to the angle: the budget by cause."""

import math
from dataclasses import dataclass

import numpy as np

from arcref.subdivision.signal_model import ChannelModel, Harmonic, SignalModel, line_phases_rad


@dataclass(frozen=True)
class Cause:
    """One fault alone on otherwise ideal signals.

    `name`; `size_arcsec`: the fault relative to the signal's amplitude, as an angle of the shaft, which is the most
    that a harmonic could do (None for causes taken together); `amplitude_arcsec`: half of the peak to peak error that
    it makes; `wave_arcsec`: amplitude of its largest wave; `orders`: waves a line with more than a tenth of
    `amplitude_arcsec`, largest first.
    """

    name: str
    size_arcsec: float | None
    amplitude_arcsec: float
    wave_arcsec: float
    orders: tuple[int, ...]


def error_harmonics(model: SignalModel, highest: int = 12) -> tuple[np.ndarray, np.ndarray]:
    """Amplitudes (arcsec) and phases (rad, of a cosine) of the error's orders 1 .. `highest` over the true phase."""
    theta = line_phases_rad()
    spectrum = np.fft.rfft(model.error_arcsec(theta))[1 : highest + 1] * (2 / theta.size)
    return np.abs(spectrum), np.angle(spectrum)


def signal_budget(model: SignalModel) -> tuple[Cause, ...]:
    """The causes one by one, each harmonic by channel and together, and all of them at last.

    Each stands alone on signals without any other fault, that begin where the sine of `model` does.
    """
    return tuple(
        _cause(name, faulty, size, model)
        for name, faulty, size in [*_offsets(model), *_shape(model), *_harmonics(model), ("all together", model, None)]
    )


def _cause(name: str, faulty: SignalModel, size: float | None, model: SignalModel) -> Cause:
    error = faulty.error_arcsec(line_phases_rad())
    waves, _ = error_harmonics(faulty)
    order = np.argsort(-waves, kind="stable")
    half = float(np.ptp(error)) / 2
    strong = tuple(int(index) + 1 for index in order if waves[index] > max(0.1 * half, 1e-12))
    return Cause(name, None if size is None else size * model.arcsec_per_rad, half, float(waves.max()), strong)


def _ideal(model: SignalModel) -> tuple[Harmonic, Harmonic]:
    """The fundamentals with one amplitude and a quarter of a line between them, the sine as it stands."""
    sine = model.sine.canonical.fundamental
    quarter = math.pi / 2 * model.cosine_sign
    return sine, Harmonic(sine.amplitude_v, sine.phase_rad + quarter)


def _signals(model: SignalModel, sine: ChannelModel, cosine: ChannelModel) -> SignalModel:
    return SignalModel(sine, cosine, model.line_count, model.cosine_sign)


def _offsets(model: SignalModel):
    first, second = _ideal(model)
    relative = model.sine.offset_v / first.amplitude_v
    other = model.cosine.offset_v / model.cosine.canonical.fundamental.amplitude_v
    for name, one, two, size in (
        ("offset of the sine", relative, 0.0, abs(relative)),
        ("offset of the cosine", 0.0, other, abs(other)),
        ("both offsets", relative, other, math.hypot(relative, other)),
    ):
        sine = ChannelModel(one * first.amplitude_v, {1: first})
        yield name, _signals(model, sine, ChannelModel(two * first.amplitude_v, {1: second})), size


def _shape(model: SignalModel):
    first, second = _ideal(model)
    other = model.cosine.canonical.fundamental
    ratio = other.amplitude_v / first.amplitude_v
    sine = ChannelModel(0.0, {1: first})
    unequal = ChannelModel(0.0, {1: Harmonic(other.amplitude_v, second.phase_rad)})
    # The error of unequal amplitudes is half their relative difference.
    yield "gain mismatch", _signals(model, sine, unequal), abs(1 - ratio) / (1 + ratio)
    lean = math.remainder(other.phase_rad - second.phase_rad, 2 * math.pi)
    leaning = ChannelModel(0.0, {1: Harmonic(first.amplitude_v, other.phase_rad)})
    yield "quadrature", _signals(model, sine, leaning), abs(lean) / 2


def _harmonics(model: SignalModel):
    first, second = _ideal(model)
    others = model.cosine.canonical.fundamental.amplitude_v
    for order in sorted({*model.sine.orders, *model.cosine.orders} - {1}):
        one = _scaled(model.sine, order, 1.0)
        two = _scaled(model.cosine, order, first.amplitude_v / others)
        size = [wave.amplitude_v / first.amplitude_v for wave in (one, two)]
        rows = (
            (f"harmonic {order} of the sine", {order: one}, {}, size[0]),
            (f"harmonic {order} of the cosine", {}, {order: two}, size[1]),
            (f"harmonic {order} of both", {order: one}, {order: two}, None),
        )
        for name, in_sine, in_cosine, relative in rows:
            sine, cosine = ChannelModel(0.0, {1: first} | in_sine), ChannelModel(0.0, {1: second} | in_cosine)
            yield name, _signals(model, sine, cosine), relative


def _scaled(channel: ChannelModel, order: int, factor: float) -> Harmonic:
    wave = channel.harmonics.get(order, Harmonic(0.0, 0.0)).canonical
    return Harmonic(wave.amplitude_v * factor, wave.phase_rad)
