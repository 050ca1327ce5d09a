#include "two_pass.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "render/shading.h"
#include "render/splat_record.h"

namespace gl_test {
namespace {

using render::NearSplat;
using render::SplatRecord;

struct Fragment {
    double w, t, push;
    double gain;   // as render::gain_of() says
    double order;  // w, or w times kCoverOrder
    glm::vec3 normal;
    uint32_t colour;
};

using Put = std::function<void(int x, int y, const Fragment&)>;

void put_record(const SplatRecord& r, const Put& put) {
    for (int y = r.y0; y <= r.y1; ++y)
        for (int x = r.x0; x <= r.x1; ++x) {
            const double dx = double(r.dx0) + x - r.x0, dy = double(r.dy0) + y - r.y0;
            const double a = double(r.l1) * dx + double(r.l2) * dy, b = double(r.l3) * dy;
            const double t = 1 - a * a - b * b;
            if (t < double(render::kEdge)) continue;
            const double s = (r.core_a * a + r.core_b * b) / double(render::kCoreScale);
            const double layer = t - s * s >= double(render::kCoreEdge) ? 1 : double(render::kCoverOrder);
            const double w = r.w + r.w_dx * dx + r.w_dy * dy;
            put(x, y, {w, t, r.push * layer, double(gain_of(r)), w * layer, {r.nx, r.ny, r.nz}, r.colour});
        }
}

// render/tile_splats-inl.h says how.
void put_near(const NearSplat& s, const geom::View& view, const Put& put) {
    const glm::dvec3 p{s.px, s.py, s.pz}, n{s.nx, s.ny, s.nz};
    const double c = s.flatness_squared, g = 1 - c, np = glm::dot(n, p);
    const glm::dvec3 u = c * p + g * np * n;
    const double pup = glm::dot(p, u);
    for (int y = s.y0; y <= s.y1; ++y)
        for (int x = s.x0; x <= s.x1; ++x) {
            const glm::dvec2 place = glm::dvec2(x + 0.5, y + 0.5) - view.principal();
            const glm::dvec3 d(place / view.focal_px, 1);
            const glm::dvec3 m = glm::cross(d, p), k = glm::cross(n, m);
            const double nd = glm::dot(n, d), du = glm::dot(d, u), dad = c * glm::dot(d, d) + g * nd * nd;
            const double chord = dad * 1.00002 - c * glm::dot(m, m) - g * glm::dot(k, k);
            double w = du / pup;
            if (pup <= c) {
                w = dad / std::max(du + std::sqrt(std::max(c * chord, 0.0)), 1e-30);
            } else if (!(chord >= 0 && du > 0)) {
                continue;
            }
            w = std::min(w, 1e6);
            const double unit = s.inverse_radius;
            put(x, y, {w * unit, double(render::kEdge), w * unit * (w / (1 + w)), 1, w * unit, n, s.colour});
        }
}

void for_each_fragment(const Splats& splats, const Put& put) {
    const render::SetupParams params(splats.view, splats.options);
    const Put put_between = [&](int x, int y, const Fragment& f) {
        if (!(f.w >= double(params.least_w) && f.w <= double(params.most_w))) return;
        const int left = x - splats.view.margins.left, top = y - splats.view.margins.top;
        if (left >= 0 && left < splats.view.width && top >= 0 && top < splats.view.height) put(left, top, f);
    };
    std::vector<NearSplat> near_splats;
    for (const std::vector<render::SplatBatch>& task : splats.tasks)
        for (const render::SplatBatch& b : task)
            for (size_t i = 0; i < size_t(b.count); ++i) {
                const auto chunk = std::make_unique<render::SplatChunk>();
                const float place[] = {b.x[i], b.y[i], b.z[i], b.radius[i]};
                const float facing[] = {b.nx[i], b.ny[i], b.nz[i], b.flatness[i]};
                std::copy_n(place, 4, chunk->place);
                std::copy_n(facing, 4, chunk->facing);
                const auto colours = std::make_unique<render::ColourChunk>();
                colours->of[0] = b.colour[i];
                SplatRecord record;
                if (set_up_splats(params, *chunk, *colours, 1, &record, near_splats) > 0)
                    put_record(record, put_between);
            }
    for (const NearSplat& splat : near_splats) put_near(splat, splats.view, put_between);
}

struct Pixel {
    double front = 0, weight = 0, largest = 0, lead = 0;
    glm::dvec3 normal{0}, colour{0};
};

glm::u8vec3 shaded(const Pixel& pixel, const render::SplatterOptions& options) {
    const double length = glm::length(pixel.normal);
    const glm::vec3 normal = length > 1e-15 ? glm::vec3(pixel.normal / length) : glm::vec3(0);
    const bool has_material = options.has_colour || options.look.shade == render::Shade::level;
    return shade_point(
        options.look.shade, normal,
        has_material ? glm::vec3(pixel.colour / pixel.weight) : glm::vec3(render::kGreyMaterial));
}

}  // namespace

render::Frame draw_in_two_passes(const Splats& splats) {
    render::Frame frame;
    frame.resize(splats.view.width, splats.view.height);
    std::vector<Pixel> pixels(frame.depth.size());
    const auto pixel_at = [&](int x, int y) -> Pixel& {
        return pixels[size_t(y) * size_t(frame.width) + size_t(x)];
    };
    for_each_fragment(splats, [&](int x, int y, const Fragment& f) {
        pixel_at(x, y).front = std::max(pixel_at(x, y).front, f.order);
    });
    for_each_fragment(splats, [&](int x, int y, const Fragment& f) {
        Pixel& pixel = pixel_at(x, y);
        if (f.order < pixel.front - f.push) return;
        const double weight = f.t * f.gain;
        if (weight > pixel.largest) pixel.largest = weight, pixel.lead = f.w;
        pixel.weight += weight;
        pixel.normal += weight * glm::dvec3(f.normal);
        pixel.colour += weight * glm::dvec3(f.colour & 255u, f.colour >> 8 & 255u, f.colour >> 16 & 255u);
    });
    for (size_t i = 0; i < pixels.size(); ++i) {
        const bool is_drawn = pixels[i].weight > 0;
        if (is_drawn) frame.depth[i] = float(splats.options.depth_unit / pixels[i].lead);
        const glm::u8vec3 c = is_drawn ? shaded(pixels[i], splats.options) : splats.options.look.background;
        for (int k = 0; k < 3; ++k) frame.rgb[3 * i + size_t(k)] = c[k];
    }
    return frame;
}

}  // namespace gl_test
