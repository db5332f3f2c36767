"""The UART's door to the registers, and the stream of captures beside it.

line -> receiver -> packets in memory -> request handler -> registers
line <- transmitter <- sender <- answers of the handler, records of the streamer
"""

from amaranth.hdl import Module, Mux, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out, connect, flipped

from arcref_gateware.link.capture_fifo import CaptureOutlet
from arcref_gateware.link.capture_streamer import CaptureStreamer
from arcref_gateware.link.packet_memory import PacketMemory
from arcref_gateware.link.packet_receiver import PacketReceiver
from arcref_gateware.link.packet_sender import PacketSender
from arcref_gateware.link.register_bus import RegisterBus
from arcref_gateware.link.request_handler import RequestHandler
from arcref_gateware.link.uart_receiver import UartReceiver
from arcref_gateware.link.uart_transmitter import UartTransmitter


class UartDoor(wiring.Component):
    """Everything between the UART's two lines and the registers. `divisor`: clocks in a bit."""

    rx: In(1, init=1)
    """The line from the host, asynchronous."""
    tx: Out(1, init=1)
    """The line to the host."""
    bus: Out(RegisterBus())
    """The registers."""
    wants_bus: Out(1)
    """1 while a request is being obeyed."""
    has_bus: In(1)
    """1 while the bus is given to this door; stays so until `wants_bus` falls."""
    enable: In(1)
    """1 to stream captures."""
    capture: Out(CaptureOutlet())
    """The oldest capture."""
    packets_refused: Out(16)
    """Packets that came broken, modulo 65536."""
    requests_obeyed: Out(1)
    """Changes with each request that was answered."""

    def __init__(self, divisor: int):
        self.divisor = divisor
        super().__init__()

    def elaborate(self, platform):
        m = Module()
        m.submodules.uart_receiver = uart_receiver = UartReceiver(self.divisor)
        m.submodules.receiver = receiver = PacketReceiver()
        m.submodules.memory = memory = PacketMemory()
        m.submodules.handler = handler = RequestHandler()
        m.submodules.streamer = streamer = CaptureStreamer()
        m.submodules.sender = sender = PacketSender()
        m.submodules.uart_transmitter = transmitter = UartTransmitter(self.divisor)
        connect(m, handler.bus, flipped(self.bus))
        connect(m, streamer.oldest, flipped(self.capture))
        m.d.comb += [
            uart_receiver.rx.eq(self.rx),
            receiver.data.eq(uart_receiver.data),
            receiver.valid.eq(uart_receiver.valid),
            receiver.bad.eq(uart_receiver.bad),
            memory.receive_valid.eq(receiver.write_valid),
            memory.receive_address.eq(receiver.write_address),
            memory.receive_data.eq(receiver.write_data),
            handler.ready.eq(receiver.ready),
            handler.part.eq(receiver.part),
            handler.length.eq(receiver.length),
            receiver.taken.eq(handler.taken),
            handler.read_data.eq(memory.read_data),
            sender.read_data.eq(memory.read_data),
            memory.read_address.eq(Mux(sender.idle, handler.read_address, sender.read_address)),
            memory.send_valid.eq(sender.write_valid),
            memory.send_address.eq(sender.write_address),
            memory.send_data.eq(sender.write_data),
            transmitter.data.eq(sender.data),
            transmitter.valid.eq(sender.valid),
            sender.ready.eq(transmitter.ready),
            self.tx.eq(transmitter.tx),
            self.wants_bus.eq(handler.wants_bus),
            handler.has_bus.eq(self.has_bus),
            self.packets_refused.eq(receiver.refused),
            self.requests_obeyed.eq(handler.obeyed),
            streamer.enable.eq(self.enable),
        ]

        # Who may put the next packet together: an answer goes before a capture.
        handler_has, streamer_has = Signal(), Signal()
        free = Signal()
        m.d.comb += [
            handler.has_sender.eq(handler_has),
            streamer.has_sender.eq(streamer_has),
            sender.push_valid.eq(Mux(handler_has, handler.push_valid, streamer.push_valid & streamer_has)),
            sender.push_data.eq(Mux(handler_has, handler.push_data, streamer.push_data)),
            sender.finish.eq(handler.finish | streamer.finish),
        ]
        # Plain data paths: a clock enable or a reset from so deep a thought would come late.
        gives_handler, gives_streamer = free & ~streamer_has, free & ~handler_has & ~handler.wants_sender
        m.d.sync += [
            # Known a clock late: the sender is not idle in the clock after `finish`.
            free.eq(sender.idle & ~sender.finish),
            handler_has.eq((handler_has | gives_handler) & handler.wants_sender & ~handler.finish),
            streamer_has.eq((streamer_has | gives_streamer) & streamer.wants_sender & ~streamer.finish),
        ]
        return m
