// Runs the Verilated core over a list of changes of its inputs, and logs every change of its outputs.
//
// Built by verilated_core.py together with the model. `core_ports.inc`, written by the build, tells the ports:
//   SAMPLES_PER_WORD, FIRST_CORRECTED_WORD, Model, Pins, raise_clocks(), eval_clock(), OUTPUT_PORTS (readers),
//   set_input_port(), MODEL_SOURCE, HAS_RESET.
// A clock here is one rising edge of the word clock: it takes one sample word and is followed by one look at the outputs.

#include <cstdint>
#include <cstring>

#include "core_ports.inc"
#include "core_stimulus.hpp"

namespace {

// When the resting blocks may rest; each bound is far more than the block needs to settle.
constexpr int64_t ROM_CHECK_CLOCKS = FIRST_CORRECTED_WORD + 64;
constexpr int64_t STROBE_CLOCKS_AFTER_CHANGE = 65536 / N + 64;  // the longest delay

// The records are read as NumPy arrays, so they must stay packed and in the order of the dtypes in core_log.py.
#pragma pack(push, 1)
struct PositionChange {
    int64_t clock, raw_position, position;
};
struct StatusChange {
    int64_t clock;
    uint8_t homed;
    uint16_t illegal_steps;
    int32_t closure_error;
    uint16_t index_count;
    uint8_t flags;
};
struct Capture {
    int64_t clock, position, raw_position, time;
};
#pragma pack(pop)

struct Run {
    const int64_t* change_time;  // in samples; the last one is followed by a time that no run reaches
    const uint8_t* change_state;
    int64_t words;
    Log<PositionChange> positions;
    Log<StatusChange> status;
    Log<Capture> captures;
    Log<SpiFrame> frames;
};

int64_t signed_48(uint64_t value) { return int64_t(value << 16) >> 16; }
int32_t signed_24(uint32_t value) { return int32_t(value << 8) >> 8; }

struct Core {
    VerilatedContext context;
    Model model{&context};
    Pins& pins = *model.rootp;  // the ports themselves: the members of Model are references to them
    SpiController spi;
    int64_t clock = 0;
    int64_t strobe_until = STROBE_CLOCKS_AFTER_CHANGE;
    uint32_t state = 0;
    PositionChange position{};
    StatusChange status{};

    Core() {
        pins.spi_cs_n = 1;
        pins.clk = 0;
        model.eval();  // initial blocks run here
        raise_clocks(pins);
    }
};

inline void log_outputs(Core& core, Run& run) {
    const Pins& pins = core.pins;
    int64_t raw = int64_t(pins.raw_position), position = int64_t(pins.position);
    if ((raw ^ core.position.raw_position) | (position ^ core.position.position)) {
        core.position = {core.clock, raw, position};  // kept as read; the sign is extended in the log alone
        run.positions.add({core.clock, signed_48(raw), signed_48(position)});
    }
    StatusChange& last = core.status;
    uint32_t closure = pins.closure_error;
    if ((pins.homed ^ last.homed) | (pins.illegal_steps ^ last.illegal_steps) | (closure ^ uint32_t(last.closure_error)) |
        (pins.index_count ^ last.index_count) | (pins.flags ^ last.flags)) {
        last = {core.clock, pins.homed, pins.illegal_steps, int32_t(closure), pins.index_count, pins.flags};
        StatusChange record = last;
        record.closure_error = signed_24(closure);
        run.status.add(record);
    }
    if (pins.capture_valid)
        run.captures.add({core.clock, signed_48(pins.capture_position), signed_48(pins.capture_raw),
                          int64_t(pins.capture_time)});
}

}  // namespace

#pragma GCC visibility push(default)
extern "C" {
Core* arcref_create() { return new Core; }
void arcref_destroy(Core* core) { delete core; }

// 0 while a frame is being read.
int arcref_plan_spi(Core* core, const SpiPlan* plan) { return core->spi.plan(*plan, core->clock); }

// Clocks the core `run->words` times. The first change must not lie before the present word.
void arcref_run(Core* core, Run* run) {
    int64_t change = 0;
    int64_t end = core->clock + run->words;
    bool mixed = true;  // the word before held a change, so the inputs must be set again
    for (; core->clock < end; core->clock++) {
        int64_t sample = core->clock * N;
        bool changes = run->change_time[change] < sample + N;
        if (changes | mixed) {
            bool strobed = set_word(core->pins, core->state, run->change_time, run->change_state, sample, change);
            if (strobed) core->strobe_until = core->clock + STROBE_CLOCKS_AFTER_CHANGE;
        }
        mixed = changes;
        if (core->clock == core->spi.next_clock) core->spi.step(core->pins, core->clock, run->frames);
        const bool strobe_runs = core->clock < core->strobe_until;
        eval_clock(core->model, core->clock < ROM_CHECK_CLOCKS, core->clock < core->spi.runs_until, strobe_runs,
                   strobe_runs);
        log_outputs(*core, *run);
    }
}

int64_t arcref_clock(const Core* core) { return core->clock; }

// Value of an output as unsigned, by its place in OUTPUT_PORTS.
uint64_t arcref_output(const Core* core, int place) { return OUTPUT_PORTS[place](core->pins); }

// Sets an input that is not part of the sample words; 0 when there is none of that name.
int arcref_set_input(Core* core, const char* name, uint64_t value) { return set_input_port(core->pins, name, value); }

// Holds the reset for some clocks, with the inputs at the first sample to come. 0 when this build has no reset port.
int arcref_reset(Core* core, int64_t clocks) {
#ifdef HAS_RESET
    core->pins.rst = 1;
    for (; clocks > 0; clocks--) eval_clock(core->model, true, true, true, true);
    core->pins.rst = 0;
    core->clock = 0;
    return 1;
#else
    (void)core, (void)clocks;
    return 0;
#endif
}
}  // extern "C"
#pragma GCC visibility pop

// In one piece with the harness, so that the compiler can put the model into the loop above.
#include MODEL_SOURCE
