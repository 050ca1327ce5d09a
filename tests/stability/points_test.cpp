// Points of a server as the client draws them, where scales, distances and fields of view are extreme: an
// image goes through server, octree and client, and comes out as a picture of the same view.
#include <gtest/gtest.h>

#include <cmath>

#include "ppve/client/point_cache.h"
#include "ppve/sample/raster_sampler.h"
#include "ppve/session.h"
#include "shapes.h"
#include "table.h"

namespace stability {
namespace {

mesh::Mesh mesh_of(const Shape& shape) {
    mesh::Mesh mesh;
    for (const glm::dvec3& v : shape.vertices) mesh.positions.push_back(glm::vec3(v));
    for (const glm::u32vec3& t : shape.triangles) mesh.triangles.push_back({t.x, t.y, t.z});
    return mesh;
}

ppve::Frustum looking(const glm::dvec3& eye, const glm::dvec3& target, double fovy_deg = 40) {
    ppve::Frustum frustum;
    frustum.view = geom::make_view({eye, target, {0, 1, 0}, fovy_deg}, 160, 120);
    frustum.view.near.reset(), frustum.view.far.reset();
    return frustum;
}

struct Seen {
    double samples = 0;
    double holes = 0;       // pixels that the server sampled and the picture has not
    double depth_off = 0;   // the largest difference of depths, by the depth
    double sent_again = 0;  // of the samples, when the same is asked for once more
};

ppve::Answer answer_of(ppve::Session& session, const ppve::Frustum& frustum, uint64_t id) {
    ppve::Request request;
    request.id = id, request.frustum = frustum;
    session.take(request);
    ppve::AnswerReport report;
    return std::get<ppve::Answer>(ppve::parse(session.answer(report), "server"));
}

// An orthographic view is not drawn: what is sent again is all that is seen of it.
Seen seen(const Shape& shape, const ppve::Frustum& frustum) {
    ppve::RasterSampler sampler{ppve::Clusters(mesh_of(shape))};
    ppve::Session session(sampler, "shape", {});
    ppve::PointCache cache(shape_around(session.welcome().bounds));
    const ppve::Answer first = answer_of(session, frustum, 1);
    const ppve::DepthImage image = image_of(first);
    Seen seen;
    seen.samples = double(image.samples());
    if (!cache.take_in(first, 1).is_in_step) return {0, INFINITY, INFINITY, INFINITY};
    const ppve::Answer again = answer_of(session, frustum, 2);
    seen.sent_again = double(again.samples_kept) / seen.samples;
    if (frustum.projection == ppve::Projection::orthographic) return seen;
    ppve::Reconstruction reconstruction;
    render::Frame frame;
    reconstruction.draw(*cache.model(), {&frustum.view, 1},
                        ppve::ReconstructionOptions::of_complete_picture(), {&frame, 1});
    for (size_t i = 0; i < image.pixels(); ++i) {
        if (image.depth[i] == 0) continue;
        const double depth = image.coding.depth(image.depth[i]);
        if (std::isfinite(frame.depth[i]))
            seen.depth_off = std::max(seen.depth_off, std::fabs(double(frame.depth[i]) / depth - 1));
        else
            ++seen.holes;
    }
    return seen;
}

// Rounding of depths to single precision, in frames and in patches.
constexpr double kDepthRounding = 1e-6;

void expect_whole(const std::string& row, const Shape& shape, const ppve::Frustum& frustum) {
    const Seen s = seen(shape, frustum);
    expect_at_least(row, "samples", s.samples, 1000);
    expect_at_most(row, "holes", s.holes, 0);
    expect_at_most(row, "depth off / depth", s.depth_off, kDepthRounding);
    expect_at_most(row, "sent again", s.sent_again, 0.002);
}

TEST(RemotePoints, SmallAndLargeScenes) {
    for (const auto& [name, scale] : {std::pair{"points_of_1e-30", 1e-30}, {"points_of_1e30", 1e30}})
        expect_whole(name, placed(bumpy_sphere(), scale, glm::dvec3(0)),
                     looking({0, 0, 3 * scale}, {0, 0, 0}));
}

// A leaf's width from the eye, and another thing 1e15 times as far.
TEST(RemotePoints, NearAndFarInOneFrame) {
    const Shape near = placed(bumpy_sphere(), 3e-7, {-6e-7, 0, -2e-6});
    const Shape far = placed(bumpy_sphere(), 3e8, {6e8, 0, -2e9});
    expect_whole("points_from_1e-6_to_1e9", joined(near, far), looking({0, 0, 0}, {0, 0, -1}));
}

TEST(RemotePoints, GrazingSurfaces) {
    expect_whole("points_grazing_at_0.1_degrees", terrain(1000), looking({0, 30, 500}, {0, 29, -73}));
}

TEST(RemotePoints, EyeInsideTheObject) {
    expect_whole("points_from_inside", bumpy_sphere(), looking({0.1, 0, 0}, {1, 0, 0}));
}

TEST(RemotePoints, NarrowFieldOfView) {
    expect_whole("points_of_1e-4_degrees", placed(bumpy_sphere(), 1e-6, glm::dvec3(0)),
                 looking({0, 0, 1.6}, {0, 0, 0}, 1e-4));
}

TEST(RemotePoints, MirroredMatrices) {
    ppve::Frustum mirrored = looking({0, 0.5, 3}, {0, 0, 0});
    mirrored.view.right = -mirrored.view.right;
    expect_whole("points_of_a_mirrored_view", bumpy_sphere(), mirrored);
}

TEST(RemotePoints, Orthographic) {
    ppve::Frustum parallel = looking({0, 0, 3}, {0, 0, 0});
    parallel.projection = ppve::Projection::orthographic;
    parallel.view.focal_px = 40;
    const Seen s = seen(bumpy_sphere(), parallel);
    expect_at_least("points_orthographic", "samples", s.samples, 1000);
    expect_at_most("points_orthographic", "sent again", s.sent_again, 0.002);
}

}  // namespace
}  // namespace stability
