// Runs the Verilated core over a list of changes of its inputs, and logs every change of its outputs.
//
// Built by verilated_core.py together with the model. `core_ports.inc`, written by the build, tells the ports:
//   SAMPLES_PER_WORD, FIRST_CORRECTED_WORD, Model, Pins, raise_clocks(), eval_clock(), OUTPUT_PORTS (readers),
//   set_input_port(), MODEL_SOURCE, HAS_RESET.
// A clock here is one rising edge of the word clock: it takes one sample word and is followed by one look at the outputs.

#include <cstdint>
#include <cstring>

#include "core_ports.inc"

namespace {

constexpr int N = SAMPLES_PER_WORD;
constexpr uint32_t ALL_SAMPLES = (1u << N) - 1;

// When the resting blocks may rest; each bound is far more than the block needs to settle.
constexpr int64_t ROM_CHECK_CLOCKS = FIRST_CORRECTED_WORD + 64;
constexpr int64_t SPI_CLOCKS_AFTER_FRAME = 16;
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
struct SpiFrame {
    int64_t clock;  // the first clock that sees chip select low
    int64_t bits;
    uint8_t data[8];
};
#pragma pack(pop)

// A log in the caller's memory. What does not fit is counted but not kept, and the caller sees that.
template <class Record> struct Log {
    Record* records;
    int64_t capacity, used;
    void add(const Record& record) {
        if (used < capacity) records[used] = record;
        used++;
    }
};

struct Run {
    const int64_t* change_time;  // in samples; the last one is followed by a time that no run reaches
    const uint8_t* change_state;
    int64_t words;
    Log<PositionChange> positions;
    Log<StatusChange> status;
    Log<Capture> captures;
    Log<SpiFrame> frames;
};

// Frames that the SPI controller is asked for. Times are in word clocks.
struct SpiPlan {
    const int64_t* start;  // chip select falls then, or as soon after as the frame before allows
    const int64_t* bits;   // chip select rises after so many bits; 64 for a whole frame
    const uint8_t* sent;   // eight bytes a frame
    int64_t frames;
    int64_t half_period_256ths;  // of SCK, in 1/256 word clock
    int64_t lead, gap;           // chip select to the first rising edge; chip select high between frames
};

int64_t signed_48(uint64_t value) { return int64_t(value << 16) >> 16; }
int32_t signed_24(uint32_t value) { return int32_t(value << 8) >> 8; }

// SPI controller, mode 0: it samples CIPO as it raises SCK and changes COPI as it lowers it.
class SpiController {
  public:
    static constexpr int64_t NEVER = INT64_MAX;
    int64_t next_clock = NEVER;
    int64_t runs_until = SPI_CLOCKS_AFTER_FRAME;  // the core's SPI port has nothing to do from then on

    bool plan(const SpiPlan& plan, int64_t now) {
        if (selected_) return false;
        plan_ = plan;
        frame_ = 0;
        begin_next(now);
        return true;
    }

    void step(Pins& pins, int64_t clock, Log<SpiFrame>& log) {
        if (!selected_) {
            selected_ = true;
            runs_until = NEVER;
            half_ = 0;
            first_edge_ = clock + plan_.lead;
            record_ = {clock, plan_.bits[frame_], {}};
            pins.spi_cs_n = 0;
            pins.spi_copi = sent_bit(0);
        } else if (half_ == 2 * record_.bits) {
            pins.spi_cs_n = 1;
            log.add(record_);
            selected_ = false;
            runs_until = clock + SPI_CLOCKS_AFTER_FRAME;
            frame_++;
            begin_next(clock + plan_.gap);
            return;
        } else {
            int64_t bit = half_ / 2;
            bool rises = half_ % 2 == 0;
            if (rises) record_.data[(bit / 8) & 7] |= uint8_t(pins.spi_cipo << (7 - bit % 8));
            else pins.spi_copi = sent_bit(bit + 1);
            pins.spi_sck = rises;
            half_++;
        }
        next_clock = first_edge_ + (half_ * plan_.half_period_256ths >> 8);
    }

  private:
    SpiPlan plan_{};
    SpiFrame record_{};
    int64_t frame_ = 0, half_ = 0, first_edge_ = 0;
    bool selected_ = false;

    void begin_next(int64_t earliest) {
        if (frame_ >= plan_.frames) next_clock = NEVER;
        else next_clock = plan_.start[frame_] > earliest ? plan_.start[frame_] : earliest;
    }
    int sent_bit(int64_t bit) const {
        return bit < 64 ? plan_.sent[8 * frame_ + bit / 8] >> (7 - bit % 8) & 1 : 0;
    }
};

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

uint32_t spread(uint32_t state, int line) { return state >> line & 1 ? ALL_SAMPLES : 0; }

// Sets the inputs to the word that starts at `sample`; moves `change` past the changes in it.
void set_word(Core& core, const Run& run, int64_t sample, int64_t& change) {
    uint32_t line[4];
    for (int i = 0; i < 4; i++) line[i] = spread(core.state, i);
    while (run.change_time[change] < sample + N) {
        uint32_t from_here = ALL_SAMPLES << (run.change_time[change] - sample) & ALL_SAMPLES;
        uint32_t state = run.change_state[change++];
        if ((state ^ core.state) >> 3) core.strobe_until = core.clock + STROBE_CLOCKS_AFTER_CHANGE;
        core.state = state;
        for (int i = 0; i < 4; i++) line[i] = (line[i] & ~from_here) | (spread(core.state, i) & from_here);
    }
    core.pins.a = line[0];
    core.pins.b = line[1];
    core.pins.z = line[2];
    core.pins.strobe = line[3];
}

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
        if (changes | mixed) set_word(*core, *run, sample, change);
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
