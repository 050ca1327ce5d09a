// What a picture lacks: the nodes that wait for their children, and how much of the picture each of them
// owns.
//
// A node owns the pixels in which it is nearest (SplatKind::ellipse's).  What is hidden owns none, and what
// is fine enough does not wait.
#pragma once

#include <glm/glm.hpp>
#include <optional>
#include <vector>

#include "scene/draw.h"

namespace scene {

// A round part of the picture that is wanted sooner.  (Streaming QSplat, section 4.3.)
struct Magnifier {
    glm::dvec2 at{0};      // pixels from the upper left corner
    double radius_px = 0;  // > 0
    double boost = 8;      // > 0: a pixel in it counts as so many

    bool holds(const glm::dvec2& p) const { return glm::dot(p - at, p - at) <= radius_px * radius_px; }
};

struct Lack {
    size_t model;  // of those that are drawn
    splat::WaitingNode node;
    glm::vec2 at_px;    // its centre in the picture
    double pixels = 0;  // owned, as the magnifier counts them
};

// Finds them for one view after the other; buffers are kept.
class LackFinder {
  public:
    explicit LackFinder(const std::vector<PlacedModel>& models) : painter_(models) {}  // which live longer

    // Of the cut that `options` ask for.  Costs about a frame of ellipses.
    std::vector<Lack> find(const geom::View& view, const DrawOptions& options,
                           const std::optional<Magnifier>& magnifier);

  private:
    ModelPainter painter_;
    render::Frame owners_;
};

}  // namespace scene
