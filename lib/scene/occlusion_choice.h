// Whether to look for what surfaces hide, by whether it paid in the frames before.
//
// Frames of a path are alike, so what did not pay hardly pays in the next one.  No clock is asked: the same
// frames in the same order are drawn in the same way on every machine.
#pragma once

#include <algorithm>
#include <cstdint>

namespace scene {

class OcclusionChoice {
  public:
    // Begins a frame.  Returns whether to look; if so note() comes later.
    bool is_due() { return pause_ == 0 || --pause_ == 0; }

    // `paid`: whether more was saved than it cost to find that out.  The first time may be chance, or the
    // path may be short; then 1, 2 and at most 4 frames are left alone.
    void note(bool paid) {
        losses_ = paid ? 0 : std::min(losses_ + 1, kMostLosses);
        pause_ = losses_ < 2 ? 0 : (1 << (losses_ - 2)) + 1;
    }

  private:
    static constexpr int kMostLosses = 4;
    int losses_ = 0;  // in turn
    int pause_ = 0;   // frames until the one that looks again, which counts
};

// What looking came to in a frame.
struct OcclusionGain {
    uint64_t nodes = 0;    // of the second outline
    double hidden = 0;     // part of them
    uint64_t splats = 0;   // that were drawn, at first
    uint64_t redrawn = 0;  // and again, where what is hidden was not proved

    // To show the map a node and look at it takes about as long as to draw a splat that is hidden; to prove
    // the rest, as an eighth of it.  Of the splats that are left out the hidden nodes' share tells most: they
    // are 1 to 1.3 times as many (both by paths round and into a dragon and a CT head).
    bool paid() const {
        const double left_out = hidden < 1 ? double(splats) * hidden / (1 - hidden) : double(splats);
        return left_out > double(redrawn) + double(nodes) + double(splats) / 8;
    }
};

}  // namespace scene
