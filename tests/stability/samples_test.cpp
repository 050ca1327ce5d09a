// Depth images where depths lie far apart, or close together far away: how far a sample is from where it was,
// seen from the side, in pixels of its image.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "ppve/sample/raster_sampler.h"
#include "table.h"

namespace stability {
namespace {

constexpr int kSquare = 8;  // pixels

// Squares that face the eye in the origin, side by side on the screen.
struct Squares {
    mesh::Mesh mesh;
    ppve::Frustum frustum;
    std::vector<double> depths;  // as single precision holds them

    Squares(const std::vector<double>& at, double focal_px, ppve::Projection projection) {
        geom::View& v = frustum.view;
        frustum.projection = projection;
        v.width = kSquare * int(at.size()), v.height = kSquare, v.focal_px = focal_px;
        for (size_t n = 0; n < at.size(); ++n) {
            const auto z = float(at[n]);
            depths.push_back(double(z));
            const double pixel = (projection == ppve::Projection::perspective ? double(z) : 1) / focal_px;
            const double left = double(int(n) * kSquare) - v.principal().x;
            const auto first = uint32_t(mesh.positions.size());
            for (const glm::dvec2 corner :
                 {glm::dvec2(0, 0), glm::dvec2(1, 0), glm::dvec2(1, 1), glm::dvec2(0, 1)})
                mesh.positions.push_back({float((left + corner.x * kSquare) * pixel),
                                          float((corner.y - 0.5) * kSquare * pixel), z});
            mesh.triangles.push_back({first, first + 1, first + 2});
            mesh.triangles.push_back({first, first + 2, first + 3});
        }
    }

    // The largest error of the samples in the squares' middles.
    double error_px() const {
        ppve::RasterSampler sampler{ppve::Clusters(mesh)};
        ppve::DepthImage image;
        image.frustum = frustum;
        ppve::prepare(sampler, 0.01, image);
        sampler.sample(image, false);
        double worst = 0;
        for (size_t n = 0; n < depths.size(); ++n) {
            const uint32_t code =
                image.depth[size_t(kSquare / 2) * size_t(image.width()) + n * kSquare + kSquare / 2];
            if (code == 0) return INFINITY;
            worst = std::max(worst, std::abs(image.coding.depth(code) - depths[n]) /
                                        ppve::footprint(frustum, 1, depths[n]));
        }
        return worst;
    }
};

std::vector<double> decades(double from, double to) {
    std::vector<double> depths;
    for (double d = from; d <= to * 1.5; d *= 10) depths.push_back(1.2345678 * d);
    return depths;
}

TEST(DepthImages, NearAndFarInOneFrame) {
    const Squares squares(decades(1e-6, 1e9), 1100, ppve::Projection::perspective);
    expect_at_most("depths_1e-6_to_1e9_in_one_frame", "error_px", squares.error_px(), 0.01);
}

TEST(DepthImages, SmallAndLargeScenes) {
    for (const auto& [name, scale] : {std::pair{"depths_of_1e-30", 1e-30}, {"depths_of_1e30", 1e30}}) {
        const Squares squares(decades(scale, 1e5 * scale), 1100, ppve::Projection::perspective);
        expect_at_most(name, "error_px", squares.error_px(), 0.01);
    }
}

// A focal length of 4e8 pixels, a field of view of a ten-thousandth of a degree: 24 bits of mantissa are not
// enough.
TEST(DepthImages, NarrowFieldOfView) {
    const Squares squares({1e6, 1e6 + 0.0625, 1e6 + 0.125, 1e6 + 1}, 4e8, ppve::Projection::perspective);
    expect_at_most("field_of_view_1e-4_degrees", "error_px", squares.error_px(), 0.01);
}

TEST(DepthImages, Orthographic) {
    const Squares squares({-1000, -1, 0.001, 1, 1000, 30000}, 500, ppve::Projection::orthographic);
    expect_at_most("orthographic_depths", "error_px", squares.error_px(), 0.01);
}

}  // namespace
}  // namespace stability
