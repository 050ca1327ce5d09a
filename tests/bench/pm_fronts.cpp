// pm_fronts: what views want of a progressive mesh, how wrong the meshes they get are, and how many faces are
// folded over at random fronts.
//
//     pm_fronts MODEL.pm [FRONTS]
//
// Views: `fit`, the eye 2.6 radii of the bounding sphere before its centre; `close`, 0.3 radii above the
// vertex that is farthest along x, looking at it; 45 degrees, 16:9.  Tolerances are shares of the picture's
// height. The error is the distance of every third vertex of the fully refined mesh that faces the eye and is
// in the picture from the nearest point of the front's mesh, as seen from the eye, by the tolerance.  What
// hides what is not asked.  Each line of output is a JSON object.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>

#include "core/error.h"
#include "core/program.h"
#include "core/stopwatch.h"
#include "geom/path.h"
#include "mesh/distance.h"
#include "pm/extract.h"
#include "pm/selection.h"

namespace {

constexpr double kHeight = 1000;  // pixels

struct Surface {
    explicit Surface(const pm::Model& model) : full(pm::mesh_of_level(model, model.details())) {
        normals.resize(full.positions.size(), glm::dvec3(0));
        for (const glm::u32vec3& t : full.triangles) {
            const glm::dvec3 n =
                glm::cross(full.world(t.y) - full.world(t.x), full.world(t.z) - full.world(t.x));
            for (int k = 0; k < 3; ++k) normals[t[k]] += n;
        }
    }
    mesh::Mesh full;
    std::vector<glm::dvec3> normals;  // by area
};

geom::Camera fit_camera(const Surface& surface) {
    const geom::Sphere bounds = geom::sphere_around(surface.full.positions);
    geom::Camera camera;
    camera.target = surface.full.origin + bounds.centre;
    camera.eye = camera.target + glm::dvec3(0, 0, 2.6 * bounds.radius);
    camera.fovy_deg = 45;
    return camera;
}

geom::Camera close_camera(const Surface& surface) {
    size_t at = 0;
    for (size_t v = 0; v < surface.full.positions.size(); ++v)
        if (surface.full.positions[v].x > surface.full.positions[at].x) at = v;
    geom::Camera camera;
    camera.target = surface.full.world(at);
    camera.eye = camera.target + 0.3 * geom::sphere_around(surface.full.positions).radius *
                                     glm::normalize(surface.normals[at]);
    camera.fovy_deg = 45;
    return camera;
}

// In tolerances, sorted.
std::vector<double> errors_of(const pm::Model& model, const Surface& surface, const pm::Front& front,
                              const pm::View& view) {
    const mesh::SurfaceDistance distance(pm::mesh_of(model, front));
    std::vector<double> errors;
    for (size_t v = 0; v < surface.full.positions.size(); v += 3) {
        const glm::dvec3 offset = surface.full.world(v) - view.eye;
        const double depth = glm::dot(offset, view.forward);
        const double x = glm::dot(offset, view.right) / depth, y = glm::dot(offset, view.down) / depth;
        const bool is_seen = depth > 0 && x >= view.low.x && x <= view.high.x && y >= view.low.y &&
                             y <= view.high.y && glm::dot(surface.normals[v], offset) < 0;
        if (is_seen)
            errors.push_back(distance.distance(surface.full.world(v), INFINITY) / glm::length(offset) /
                             view.tolerance);
    }
    std::sort(errors.begin(), errors.end());
    return errors;
}

void measure_view(const pm::Model& model, const Surface& surface, const char* name,
                  const geom::Camera& camera, double share) {
    const pm::View view =
        pm::make_view(geom::make_view(camera, int(kHeight * 16 / 9), int(kHeight)), share * kHeight);
    pm::Selection selection(model);
    selection.select(view);
    double best_ms = INFINITY;
    for (int run = 0; run < 5; ++run) {
        core::Stopwatch watch;
        selection.select(view);
        best_ms = std::min(best_ms, watch.lap_ms());
    }
    pm::Front front(model.hierarchy());
    front.assign(selection.select(view));
    const pm::SelectionCounts& c = selection.counts();
    const std::vector<double> errors = errors_of(model, surface, front, view);
    double squares = 0;
    for (const double e : errors) squares += e * e;
    const auto within = std::upper_bound(errors.begin(), errors.end(), 1.1) - errors.begin();
    core::print(core::Json{{"view", name},
                           {"tolerance", core::text("1/%.0f", 1 / share)},
                           {"splits", front.split_count()},
                           {"faces", front.face_count()},
                           {"accurate", c.accurate},
                           {"outside", c.outside},
                           {"faces_away", c.faces_away},
                           {"blocked", c.blocked},
                           {"rms", std::sqrt(squares / double(errors.size()))},
                           {"p999", errors[size_t(0.999 * double(errors.size() - 1))]},
                           {"max", errors.back()},
                           {"within_1_1", double(within) / double(errors.size())},
                           {"select_ms", best_ms}}
                    .dump() +
                "\n");
}

// Faces turned by more than 90 degrees from the face of the fully refined mesh with the same leaf corners, of
// those whose corners are not all leaves.
void measure_fold_overs(const pm::Model& model, int fronts) {
    const pm::Hierarchy tree = model.hierarchy();
    std::mt19937_64 random(1);
    for (int f = 1; f <= fronts; ++f) {
        pm::Front front(tree);
        const auto wanted = uint64_t(double(model.details()) * f / (fronts + 1));
        while (front.split_count() < wanted) {
            const auto d = uint32_t(random() % model.details());
            if (front.can_split(d)) front.split(d);
        }
        uint64_t moved = 0, folded = 0;
        const auto look_at = [&](const glm::u32vec3& leaf) {
            if (leaf.x == pm::kNone) return;
            const glm::u32vec3 at(front.active(leaf.x), front.active(leaf.y), front.active(leaf.z));
            if (at == leaf) return;
            const auto normal = [&](const glm::u32vec3& v) {
                return glm::cross(model.unit(v.y) - model.unit(v.x), model.unit(v.z) - model.unit(v.x));
            };
            ++moved;
            folded += glm::dot(normal(at), normal(leaf)) < 0;
        };
        for (const glm::u32vec3& face : tree.base_faces) look_at(face);
        for (uint32_t d = 0; d < tree.details(); ++d)
            if (front.is_split(d)) look_at(tree.faces[d].left), look_at(tree.faces[d].right);
        core::print(core::Json{{"view", "random front"},
                               {"splits", front.split_count()},
                               {"moved_faces", moved},
                               {"folded", double(folded) / double(std::max<uint64_t>(moved, 1))}}
                        .dump() +
                    "\n");
    }
}

}  // namespace

int main(int argc, char** argv) {
    if (argc < 2) return std::fprintf(stderr, "usage: pm_fronts MODEL.pm [FRONTS]\n"), 2;
    try {
        const pm::Model model(argv[1]);
        const Surface surface(model);
        for (const double share : {1.0 / 200, 1.0 / 1000}) {
            measure_view(model, surface, "fit", fit_camera(surface), share);
            measure_view(model, surface, "close", close_camera(surface), share);
        }
        measure_fold_overs(model, argc > 2 ? std::atoi(argv[2]) : 5);
    } catch (const core::Error& error) {
        return std::fprintf(stderr, "pm_fronts: %s\n", error.what()), 1;
    }
}
