#include "view/status.h"

#include <array>
#include <cmath>

#include "core/error.h"
#include "render/shading.h"

namespace view {

namespace {

using core::text;

// Three digits and a unit: "412 k", "3.10 M".
std::string short_number(double value) {
    constexpr std::array<const char*, 4> kUnits{"", " k", " M", " G"};
    size_t unit = 0;
    for (; value >= 999.5 && unit + 1 < kUnits.size(); ++unit) value /= 1000;
    const int decimals = unit == 0 || value >= 99.95 ? 0 : value >= 9.995 ? 1 : 2;
    return text("%.*f%s", decimals, value, kUnits[unit]);
}

std::string bytes_text(double bytes) {
    const std::string number = short_number(bytes);
    return number + (number.find(' ') == number.npos ? " B" : "B");
}

}  // namespace

std::string status_line(const PictureReport& r, const Rates& rates) {
    std::string line;
    const auto add = [&](const std::string& part) { line += (line.empty() ? "" : "   ") + part; };
    if (rates.pictures_per_s >= 0.5) add(text("%.0f frames/s", rates.pictures_per_s));
    if (r.splats > 0 || r.triangles == 0) add(short_number(double(r.splats)) + " splats");
    if (r.triangles > 0) add(short_number(double(r.triangles)) + " triangles");
    if (r.threshold_px > 0) add(text("threshold %.3g px", r.threshold_px));
    if (std::isfinite(r.error_bound_px)) add(text("error below %.3g px", r.error_bound_px));
    if (r.bytes_touched > 0) add(bytes_text(double(r.bytes_touched)) + " read");
    if (r.arrival) {
        if (r.arrival->blocks_missing > 0)
            add(text("%llu blocks missing", static_cast<unsigned long long>(r.arrival->blocks_missing)));
        add(bytes_text(double(r.arrival->bytes_fetched)) + " fetched");
        add(bytes_text(rates.bytes_per_s) + "/s");
    }
    return line;
}

std::vector<LegendEntry> legend(const PictureReport& report) {
    std::vector<LegendEntry> entries;
    constexpr int kMostPx = 128;
    entries.push_back({render::level_colour(0.5f),
                       report.has_leaf_triangles ? "below 1 px, or the mesh itself" : "below 1 px"});
    for (int px = 1; px < kMostPx; px *= 2)
        entries.push_back({render::level_colour(float(px)), text("%d to %d px", px, 2 * px)});
    entries.push_back({render::level_colour(float(kMostPx)), text("%d px and more", kMostPx)});
    return entries;
}

std::vector<KeyHelp> key_help() {
    return {{"left drag", "turn; let go in motion, it spins on"},
            {"right or shift drag", "move the picture"},
            {"wheel, ctrl drag", "nearer to what is under the mouse; nearer"},
            {"double click", "turn about what is there"},
            {"arrows, + -", "turn by 5 degrees; nearer, farther"},
            {"[ ]", "narrower, wider field of view"},
            {"L drag, K", "light from where the mouse is; from the eye"},
            {"M", "while held: magnifying glass"},
            {"C, N", "colour by resolution; by normals"},
            {"H", "home"},
            {"1-9, ctrl 1-9", "go to a saved view; save it"},
            {", .", "more time, less time for a frame in motion"},
            {"page up, page down", "finer, coarser at rest"},
            {"S", "screenshot"},
            {"R", "record the camera; R again ends it"},
            {"P", "print the camera on standard output"},
            {"I, F11", "hide or show the status line; full screen"},
            {"F5", "open the source anew; a file dropped is opened"},
            {"space", "stand still"},
            {"F1", "these keys"},
            {"Q, escape", "quit"}};
}

}  // namespace view
