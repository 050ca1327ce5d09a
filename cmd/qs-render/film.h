// Drawing the frames of a path, and writing what was asked for of each.
#pragma once

#include <array>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/report.h"
#include "geom/path.h"
#include "qs-render/arguments.h"
#include "qs-render/picture_files.h"
#include "scene/backends.h"
#include "scene/budget_painter.h"
#include "scene/draw.h"
#include "scene/frame_report.h"
#include "scene/reference.h"
#include "scene/shots.h"
#include "scene/sources.h"
#include "scene/stream.h"

namespace qs_render {

// Throws core::UsageError where the back end cannot leave out what is hidden, and is to.
void check_occlusion(const scene::DrawOptions& draw, const scene::ModelPainter& painter,
                     const std::string& backend);

// All that is given lives longer.
class Film {
  public:
    Film(const Arguments& arguments, const scene::DrawOptions& options, const scene::Models& models,
         const std::vector<std::string>& inputs, double frames_per_s, scene::Backend backend);

    // Where models are arriving: asks for what a frame shows that is taken later.
    void expect(const geom::PathFrame& shot);

    // One camera: for each eye once, or with --refine again and again; the last picture is written.
    void take(int number, const geom::PathFrame& shot);

    // Where models are arriving: `stream` asks for what pictures lack, and is told of each.
    void follow(scene::Stream& stream) { stream_ = &stream; }

    void finish();

  private:
    // What an eye sees, and what each of its drawings cost.
    struct Picture {
        render::Frame frame;
        std::vector<scene::FrameReport> lines;
    };

    std::span<Picture> draw_eyes(int number, const geom::PathFrame& shot);
    void begin_streaming(int number, const std::vector<scene::EyeView>& views);
    void end_streaming(std::span<Picture> pictures);
    void draw_again_and_again(const geom::View& view, scene::FrameReport line, Picture& picture);
    void draw(const geom::View& view, bool is_first, scene::FrameReport& line, render::Frame& frame);
    void measure(const geom::View& view, scene::FrameReport& line, const render::Frame& frame);
    void write(Picture& picture);
    void count(scene::FrameReport line);
    void say_how_budget_was_held() const;

    const Arguments& a_;
    const scene::DrawOptions& options_;
    const scene::Screen screen_;
    scene::Stream* stream_ = nullptr;
    uint64_t unsettled_count_ = 0, cut_short_count_ = 0;  // frames that lack what is seen; for want of bytes
    const bool are_complete_;
    core::Report report_;
    PictureFiles files_;
    std::unique_ptr<scene::Reference> reference_;
    std::string backend_;
    scene::ModelPainter painter_;
    std::optional<scene::BudgetPainter> budget_painter_;
    std::array<Picture, 2> pictures_;  // kept from frame to frame
    size_t drawn_count_ = 0, coarse_count_ = 0, late_count_ = 0, empty_count_ = 0;  // pictures
    size_t measured_count_ = 0, beyond_bound_count_ = 0;                            // drawings of these
    double fastest_ms_ = std::numeric_limits<double>::infinity();
};

}  // namespace qs_render
