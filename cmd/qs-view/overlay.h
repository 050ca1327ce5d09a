// What is written over the picture, by Dear ImGui.
#pragma once

#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "view/status.h"

namespace qs_view {

struct OverlayContent {
    std::string status;  // empty: hidden
    // 1: no bar; a download of 0: on its way, of unknown length.
    double refinement = 1, download = 1;
    bool has_keys = false;
    std::vector<view::LegendEntry> legend;  // empty: none
    std::string message;                    // in the middle: what is wrong, or waited for
    std::string note;                       // above the status line: what was just done
    bool is_recording = false;
};

// Of a device that is current as long as it lives.
class Overlay {
  public:
    explicit Overlay(double scale);
    ~Overlay();
    Overlay(const Overlay&) = delete;
    Overlay& operator=(const Overlay&) = delete;

    void draw(const OverlayContent& content, const glm::ivec2& size_px);
};

}  // namespace qs_view
