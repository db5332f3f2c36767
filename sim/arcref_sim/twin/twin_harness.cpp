// Runs the Verilated instrument over a list of changes of its inputs, with a UART and an SPI controller at its pins.
//
// `core_ports.inc`, written by the build, tells the ports as for harness.cpp. A clock here is one rising edge of the
// word clock. Bytes from the host go to uart_rx and bytes of uart_tx to the host, at so many clocks a bit.

#include <cstdint>
#include <cstring>

#include "core_ports.inc"
#include "core_stimulus.hpp"

namespace {

struct Run {
    const int64_t* change_time;  // in samples; the last one is followed by a time that no run reaches
    const uint8_t* change_state;
    int64_t words;
    const uint8_t* sent;  // bytes from the host, of which `taken` have begun
    int64_t sent_bytes, taken;
    Log<uint8_t> received;  // bytes to the host
    Log<int64_t> compare;   // clocks at which the compare output rises and falls
    Log<SpiFrame> frames;
};

// Eight data bits, no parity, one stop bit, at both pins.
class Uart {
  public:
    explicit Uart(int64_t divisor) : divisor_(divisor) {}

    // The level of uart_rx that the next clock is to see.
    void send(Pins& pins, int64_t clock, Run& run) {
        if (clock < next_bit_) return;
        if (bits_left_ == 0) {
            if (run.taken == run.sent_bytes) return;
            shift_ = 1u << 9 | uint32_t(run.sent[run.taken++]) << 1;
            bits_left_ = 10;
        }
        pins.uart_rx = shift_ & 1;
        shift_ >>= 1;
        bits_left_--;
        next_bit_ = clock + divisor_;
    }

    // Looks at uart_tx after a clock: a start bit is found at its edge, and each bit is taken in its middle.
    void receive(const Pins& pins, int64_t clock, Log<uint8_t>& log) {
        if (place_ < 0) {
            if (pins.uart_tx) return;
            place_ = 0;
            byte_ = 0;
            next_look_ = clock + divisor_ + divisor_ / 2;
            return;
        }
        if (clock < next_look_) return;
        next_look_ += divisor_;
        if (place_ < 8) {
            byte_ |= uint32_t(pins.uart_tx) << place_++;
            return;
        }
        if (pins.uart_tx) log.add(uint8_t(byte_));  // without a stop bit it is no byte
        place_ = -1;
    }

    // True while a byte goes either way.
    bool busy() const { return bits_left_ || place_ >= 0; }

  private:
    int64_t divisor_;
    int64_t next_bit_ = 0, next_look_ = 0;
    uint32_t shift_ = 0, byte_ = 0;
    int bits_left_ = 0, place_ = -1;
};

struct Instrument {
    VerilatedContext context;
    Model model{&context};
    Pins& pins = *model.rootp;
    Uart uart;
    SpiController spi;
    int64_t clock = 0;
    uint32_t state = 0;
    uint8_t compare = 0;

    explicit Instrument(int64_t divisor) : uart(divisor) {
        pins.spi_cs_n = 1;
        pins.uart_rx = 1;
        pins.clk = 0;
        model.eval();  // initial blocks run here
        raise_clocks(pins);
    }
};

}  // namespace

#pragma GCC visibility push(default)
extern "C" {
Instrument* twin_create(int64_t divisor) { return new Instrument(divisor); }
void twin_destroy(Instrument* instrument) { delete instrument; }

// 0 while a frame is being read.
int twin_plan_spi(Instrument* instrument, const SpiPlan* plan) {
    return instrument->spi.plan(*plan, instrument->clock);
}

// Clocks the instrument `run->words` times. The first change must not lie before the present word.
void twin_run(Instrument* instrument, Run* run) {
    Pins& pins = instrument->pins;
    int64_t change = 0, clock = instrument->clock;
    const int64_t end = clock + run->words;
    bool mixed = true;  // the word before held a change, so the inputs must be set again
    for (; clock < end; clock++) {
        int64_t sample = clock * N;
        bool changes = run->change_time[change] < sample + N;
        if (changes | mixed)
            set_word(pins, instrument->state, run->change_time, run->change_state, sample, change);
        mixed = changes;
        instrument->uart.send(pins, clock, *run);
        if (clock == instrument->spi.next_clock) instrument->spi.step(pins, clock, run->frames);
        eval_clock(instrument->model);
        instrument->uart.receive(pins, clock, run->received);
        if (pins.compare != instrument->compare) {
            instrument->compare = pins.compare;
            run->compare.add(clock);
        }
    }
    instrument->clock = clock;
}

int64_t twin_clock(const Instrument* instrument) { return instrument->clock; }
int twin_busy(const Instrument* instrument) { return instrument->uart.busy(); }

// Value of an output as unsigned, by its place in OUTPUT_PORTS.
uint64_t twin_output(const Instrument* instrument, int place) { return OUTPUT_PORTS[place](instrument->pins); }
}  // extern "C"
#pragma GCC visibility pop

// In one piece with the harness, so that the compiler can put the model into the loop above.
#include MODEL_SOURCE
