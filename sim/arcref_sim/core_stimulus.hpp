// What stands at the pins of a core in simulation: its sample words, made of a list of changes, and an SPI controller.
//
// Included by the harnesses behind `core_ports.inc`, which gives Pins and SAMPLES_PER_WORD.

#pragma once

#include <cstdint>

namespace {

constexpr int N = SAMPLES_PER_WORD;
constexpr uint32_t ALL_SAMPLES = (1u << N) - 1;

// A log in the caller's memory. What does not fit is counted but not kept, and the caller sees that.
template <class Record> struct Log {
    Record* records;
    int64_t capacity, used;
    void add(const Record& record) {
        if (used < capacity) records[used] = record;
        used++;
    }
};

// Read as a NumPy array, so it stays packed and in the order of SPI_FRAME in core_log.py.
#pragma pack(push, 1)
struct SpiFrame {
    int64_t clock;  // the first clock that sees chip select low
    int64_t bits;
    uint8_t data[8];
};
#pragma pack(pop)

// Frames that the SPI controller is asked for. Times are in word clocks.
struct SpiPlan {
    const int64_t* start;  // chip select falls then, or as soon after as the frame before allows
    const int64_t* bits;   // chip select rises after so many bits; 64 for a whole frame
    const uint8_t* sent;   // eight bytes a frame
    int64_t frames;
    int64_t half_period_256ths;  // of SCK, in 1/256 word clock
    int64_t lead, gap;           // chip select to the first rising edge; chip select high between frames
};

// SPI controller, mode 0: it samples CIPO as it raises SCK and changes COPI as it lowers it.
class SpiController {
  public:
    static constexpr int64_t NEVER = INT64_MAX;
    static constexpr int64_t CLOCKS_AFTER_FRAME = 16;  // far more than the core's SPI port needs to settle
    int64_t next_clock = NEVER;
    int64_t runs_until = CLOCKS_AFTER_FRAME;  // the core's SPI port has nothing to do from then on

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
            runs_until = clock + CLOCKS_AFTER_FRAME;
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

uint32_t spread(uint32_t state, int line) { return state >> line & 1 ? ALL_SAMPLES : 0; }

// Sets A, B, Z and the strobe to the word that starts at `sample`. `state` holds the lines before it and after it, and
// `change` moves past the changes in the word. True when the strobe changes in it.
inline bool set_word(Pins& pins, uint32_t& state, const int64_t* change_time, const uint8_t* change_state,
                     int64_t sample, int64_t& change) {
    uint32_t line[4];
    bool strobe_changes = false;
    for (int i = 0; i < 4; i++) line[i] = spread(state, i);
    while (change_time[change] < sample + N) {
        uint32_t from_here = ALL_SAMPLES << (change_time[change] - sample) & ALL_SAMPLES;
        uint32_t next = change_state[change++];
        strobe_changes |= (next ^ state) >> 3;
        state = next;
        for (int i = 0; i < 4; i++) line[i] = (line[i] & ~from_here) | (spread(state, i) & from_here);
    }
    pins.a = line[0];
    pins.b = line[1];
    pins.z = line[2];
    pins.strobe = line[3];
    return strobe_changes;
}

}  // namespace
