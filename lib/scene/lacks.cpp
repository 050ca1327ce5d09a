#include "scene/lacks.h"

#include <atomic>

namespace scene {

namespace {

// Ids are what shading without light leaves of colours.
DrawOptions showing_owners(DrawOptions options, std::atomic<uint32_t>& last_number) {
    options.cut.last_number = &last_number;
    options.kind = render::SplatKind::ellipse;
    options.look = {};
    options.look.shade = render::Shade::flat;
    options.occlusion = Occlusion::off;
    return options;
}

// By number; 0 is what does not wait.
std::vector<double> count_pixels(const render::Frame& owners, uint32_t last_number,
                                 const geom::Margins& margins, const std::optional<Magnifier>& magnifier) {
    std::vector<double> pixels(size_t(last_number) + 1, 0.0);
    const uint8_t* rgb = owners.rgb.data();
    for (int y = 0; y < owners.height; ++y)
        for (int x = 0; x < owners.width; ++x, rgb += 3) {
            const uint32_t number = uint32_t(rgb[0]) | uint32_t(rgb[1]) << 8 | uint32_t(rgb[2]) << 16;
            if (number == 0 || number > last_number) continue;
            const glm::dvec2 at(x + margins.left + 0.5, y + margins.top + 0.5);
            pixels[number] += magnifier && magnifier->holds(at) ? magnifier->boost : 1;
        }
    return pixels;
}

}  // namespace

std::vector<Lack> LackFinder::find(const geom::View& view, const DrawOptions& options,
                                   const std::optional<Magnifier>& magnifier) {
    std::atomic<uint32_t> last_number{0};
    painter_.draw(view, showing_owners(options, last_number), owners_);
    const std::vector<double> pixels = count_pixels(owners_, last_number, view.margins, magnifier);
    std::vector<Lack> lacks;
    for (size_t model = 0; model < painter_.size(); ++model)
        for (const splat::WaitingNode& node : painter_.waiting(model)) {
            const glm::dvec2 at =
                view.principal() + view.focal_px * glm::dvec2(node.centre) / double(node.centre.z);
            lacks.push_back({model, node, glm::vec2(at), pixels[node.number]});
        }
    return lacks;
}

}  // namespace scene
