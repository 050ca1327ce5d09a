// Cameras where projections lose their footing, before a surface of radius 1.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "core/error.h"
#include "splat/walk.h"
#include "subject.h"
#include "table.h"

namespace stability {
namespace {

const Subject& unit_model() {
    static const Subject subject = build(bumpy_sphere(), Precision::single);
    return subject;
}

// A leaf near the middle of the front.
splat::Node front_leaf() {
    splat::Node best;
    best.centre = glm::dvec3(-1);
    const splat::Model& model = *unit_model().model;
    splat::walk(model, model.header().level_count, [&](const splat::WalkedNode& walked) {
        if (walked.node.children == 0 && walked.node.centre.z > best.centre.z) best = walked.node;
    });
    const splat::Header& h = model.header();
    best.centre = h.origin + h.scale * best.centre;
    best.radius = float(h.scale * double(best.radius));
    return best;
}

geom::Camera look(const glm::dvec3& eye, const glm::dvec3& target, double fovy_deg = 30,
                  const glm::dvec3& up = {0, 1, 0}) {
    geom::Camera camera;
    camera.eye = eye, camera.target = target, camera.up = up, camera.fovy_deg = fovy_deg;
    return camera;
}

struct Shot {
    const char* name;
    std::function<geom::Camera()> camera;
    bool is_before_all;  // the whole model is before the eye: the bound is finite
    bool is_seen;        // something is in the picture
};

std::ostream& operator<<(std::ostream& out, const Shot& shot) {
    return out << shot.name;
}

const Shot kShots[] = {
    {"fitted",
     [] {
         return look({0, 0, 5}, {0, 0, 0});
     },
     true, true},
    {"inside_a_leaf_looking_out",
     [] {
         const splat::Node leaf = front_leaf();
         return look(leaf.centre, leaf.centre + glm::dvec3(leaf.normal));
     },
     false, true},
    {"inside_a_leaf_looking_in",
     [] {
         const splat::Node leaf = front_leaf();
         return look(leaf.centre, leaf.centre - glm::dvec3(leaf.normal));
     },
     false, true},
    {"inside_a_leaf_along_it",
     [] {
         const splat::Node leaf = front_leaf();
         return look(leaf.centre, leaf.centre + glm::dvec3(1, 0, 0));
     },
     false, true},
    {"in_the_middle",
     [] {
         return look({0, 0, 0}, {0.3, 0.2, -1}, 90);
     },
     false, true},
    {"surface_at_near_depth",
     [] {
         geom::Camera camera = look({0, 0, 3}, {0, 0, 0});
         camera.near = 3 - front_leaf().centre.z, camera.far = 10;
         return camera;
     },
     true, true},
    {"eye_plane_touches_surface",
     [] {
         const splat::Node leaf = front_leaf();
         const glm::dvec3 n(leaf.normal);
         const glm::dvec3 across = glm::normalize(glm::cross(n, glm::dvec3(0.3, 1, 0)));
         return look(leaf.centre + 1.5 * double(leaf.radius) * n,
                     leaf.centre + 1.5 * double(leaf.radius) * n + across, 60);
     },
     false, false},
    {"1e_9_radii_before_surface",
     [] {
         const splat::Node leaf = front_leaf();
         return look(leaf.centre + 1e-9 * glm::dvec3(leaf.normal), leaf.centre);
     },
     false, true},
    {"1e_3_radii_before_surface",
     [] {
         const splat::Node leaf = front_leaf();
         const glm::dvec3 n(leaf.normal);
         return look(leaf.centre + (double(leaf.radius * leaf.flatness) + 1e-3) * n, leaf.centre);
     },
     false, true},
    {"1e9_radii_away",
     [] {
         return look({6e8, 0, 8e8}, {0, 0, 0});
     },
     true, false},
    {"1e9_radii_away_telescope",
     [] {
         return look({6e8, 0, 8e8}, {0, 0, 0}, 2e-7);
     },
     true, true},
    {"1e9_radii_past_it",
     [] {
         return look({0, 0, 5}, {1e9, 1e9, -1e9});
     },
     false, false},
    {"fov_0_001",
     [] {
         return look({0, 0, 5}, {0.1, 0.2, 0}, 0.001);
     },
     true, true},
    {"fov_179",
     [] {
         return look({0, 0, 2}, {0, 0, 0}, 179);
     },
     true, false},
    {"fov_179_at_surface",
     [] {
         return look({0, 0, 1.05}, {0, 0, 0}, 179);
     },
     false, true},
    {"along_up",
     [] {
         return look({0, 6, 0}, {0, 0, 0});
     },
     true, true},
    {"against_up",
     [] {
         return look({0, -6, 0}, {0, 0, 0});
     },
     true, true},
    {"nearly_along_up",
     [] {
         return look({6e-17, 6, 0}, {0, 0, 0});
     },
     true, true},
    {"up_is_0",
     [] {
         return look({0, 1, 6}, {0, 0, 0}, 30, {0, 0, 0});
     },
     true, true},
    {"away_from_model",
     [] {
         return look({0, 0, 5}, {0, 0, 10});
     },
     true, false},
};

class Cameras : public testing::TestWithParam<Shot> {};

TEST_P(Cameras, DrawWithinTheBound) {
    const Shot& shot = GetParam();
    const Subject& subject = unit_model();
    const geom::Camera camera = shot.camera();
    for (const render::SplatKind kind : {render::SplatKind::smooth, render::SplatKind::ellipse}) {
        const std::string row =
            shot.name + std::string(kind == render::SplatKind::smooth ? " smooth" : " ellipse");
        scene::DrawOptions options = all_detail();
        options.kind = kind;
        options.cut.cull_backfaces = shot.is_before_all;
        const Picture picture = draw(subject, camera, options);
        const double bound = picture.report.counts.error_bound_px;
        expect_at_most(row, "bad pixels", double(bad_pixels(picture.frame)), 0);
        expect_at_most(row, "holes", double(difference_from_mesh(subject, picture).holes), 0);
        if (shot.is_seen) expect_at_least(row, "covered pixels", double(covered_pixels(picture.frame)), 1);
        if (shot.is_before_all) {
            EXPECT_TRUE(std::isfinite(bound));
        }
        expect_at_most(row, "error px", measured_error_px(subject, picture),
                       bound + measurement_rounding_px(picture));
    }
    for (const render::SplatKind kind : {render::SplatKind::square, render::SplatKind::circle}) {
        scene::DrawOptions options = all_detail();
        options.kind = kind;
        EXPECT_EQ(bad_pixels(draw(subject, camera, options).frame), 0u);
    }
}

INSTANTIATE_TEST_SUITE_P(Table, Cameras, testing::ValuesIn(kShots), testing::PrintToStringParamName());

struct BadCamera {
    const char* name;
    geom::Camera camera;
    const char* says;
};

std::ostream& operator<<(std::ostream& out, const BadCamera& bad) {
    return out << bad.name;
}

const BadCamera kBadCameras[] = {
    {"eye_equal_to_target", look({1, 2, 3}, {1, 2, 3}), "eye"},
    {"eye_a_rounding_from_target", look({1e12, 0, 0}, {1e12 + 1e-4, 0, 0}), "eye"},
    {"fov_0", look({0, 0, 5}, {0, 0, 0}, 0), "fov"},
    {"fov_180", look({0, 0, 5}, {0, 0, 0}, 180), "fov"},
    {"nan_eye", look({std::nan(""), 0, 5}, {0, 0, 0}), "finite"},
};

class BadCameras : public testing::TestWithParam<BadCamera> {};

TEST_P(BadCameras, AreRefusedWithAReason) {
    try {
        geom::make_view(GetParam().camera, 200, 150);
        FAIL() << "it was taken";
    } catch (const core::Error& error) {
        EXPECT_NE(std::string(error.what()).find(GetParam().says), std::string::npos) << error.what();
    }
}

INSTANTIATE_TEST_SUITE_P(Table, BadCameras, testing::ValuesIn(kBadCameras),
                         testing::PrintToStringParamName());

}  // namespace
}  // namespace stability
