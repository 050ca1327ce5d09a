#include "subject.h"

#include <stdlib.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <system_error>

#include "core/error.h"
#include "core/file.h"
#include "core/parallel.h"
#include "geom/path.h"
#include "mesh/distance.h"
#include "render/compare.h"
#include "render/raster.h"
#include "scene/reference.h"
#include "splat/walk.h"

namespace stability {
namespace {

// A place for one file, gone with the object; who has mapped the file by then keeps it.
class TemporaryFile {
  public:
    TemporaryFile() : folder_((std::filesystem::temp_directory_path() / "qs-stability-XXXXXX").string()) {
        if (::mkdtemp(folder_.data()) == nullptr) throw core::Error(folder_ + ": cannot create");
    }
    ~TemporaryFile() {
        std::error_code ignored;
        std::filesystem::remove_all(folder_, ignored);
    }
    TemporaryFile(const TemporaryFile&) = delete;
    TemporaryFile& operator=(const TemporaryFile&) = delete;

    std::string path() const { return folder_ + "/model.qs"; }

  private:
    std::string folder_;
};

std::vector<splat::Node> leaves_of(const splat::Model& model) {
    std::vector<splat::Node> leaves;
    splat::walk(model, model.header().level_count, [&](const splat::WalkedNode& walked) {
        if (walked.node.children == 0) leaves.push_back(walked.node);
    });
    return leaves;
}

// Bound on the distance of `p` from the ellipsoid of `leaf`; 0 or less inside.  Model units.
double outside(const splat::Node& leaf, const glm::dvec3& p) {
    const glm::dvec3 d = p - leaf.centre, n(leaf.normal);
    const double along = glm::dot(d, n), square = std::max(0.0, glm::dot(d, d) - along * along);
    const double radius = double(leaf.radius), thin = along / double(leaf.flatness);
    return std::sqrt(square + thin * thin) - radius;
}

std::vector<glm::dvec3> vertices_to_cover(const Subject& subject) {
    std::vector<uint8_t> used(subject.shape.vertices.size(), subject.mesh.is_cloud());
    for (const glm::u32vec3& t : subject.shape.triangles)
        for (int k = 0; k < 3; ++k) used[t[k]] = 1;
    std::vector<glm::dvec3> vertices;
    for (size_t v = 0; v < used.size(); ++v) {
        const glm::dvec3& p = subject.shape.vertices[v];
        if (used[v] && std::isfinite(p.x + p.y + p.z)) vertices.push_back(p);
    }
    return vertices;
}

}  // namespace

Subject build(const Shape& shape, Precision precision, const mesh::ReadOptions& options, splat::Leaf leaf) {
    const std::string ply = to_ply(shape, precision);
    mesh::ReadResult read = mesh::read_mesh_bytes(std::as_bytes(std::span(ply)), "shape.ply", options);
    Subject subject;
    subject.shape = shape;
    subject.mesh = read.mesh;
    subject.counts = read.counts;
    const TemporaryFile file;
    core::OutputFile out(file.path());
    subject.report = splat::build(std::move(read.mesh), {.leaf = leaf}, out, "shape.ply");
    out.commit();
    const core::InputFile in(file.path());
    subject.bytes.assign(reinterpret_cast<const char*>(in.bytes().data()), in.bytes().size());
    subject.model = std::make_unique<splat::Model>(core::InputFile(file.path()));
    return subject;
}

core::InputFile nameless_file(const std::string& bytes) {
    const TemporaryFile file;
    core::OutputFile out(file.path());
    out.write(bytes);
    out.commit();
    return core::InputFile(file.path());
}

double worst_uncovered_vertex(const Subject& subject) {
    const std::vector<splat::Node> leaves = leaves_of(*subject.model);
    const splat::Header& h = subject.model->header();
    const std::vector<glm::dvec3> vertices = vertices_to_cover(subject);
    std::vector<double> nearest(vertices.size(), std::numeric_limits<double>::infinity());
    core::parallel_for(vertices.size(), [&](size_t v) {
        const glm::dvec3 p = (vertices[v] - h.origin) / h.scale;
        for (const splat::Node& leaf : leaves) {
            nearest[v] = std::min(nearest[v], outside(leaf, p));
            if (nearest[v] <= 0) break;
        }
    });
    double worst = 0;
    for (const double d : nearest) worst = std::max(worst, d);
    return worst;
}

scene::DrawOptions all_detail() {
    scene::DrawOptions options;
    options.cut.threshold_px = 0;
    return options;
}

Picture draw(const Subject& subject, const geom::Camera& camera, const scene::DrawOptions& options) {
    constexpr int kWidth = 200, kHeight = 150;
    Picture picture;
    picture.view = geom::make_view(camera, kWidth, kHeight);
    picture.report = scene::ModelPainter(*subject.model).draw(picture.view, options, picture.frame);
    return picture;
}

geom::Camera fitted_camera(const Subject& subject) {
    const splat::Header& h = subject.model->header();
    return geom::orbit({h.origin, h.scale}, geom::Shot{.frames = 1, .aspect = 4.0 / 3}).front();
}

uint64_t bad_pixels(const render::Frame& frame) {
    return uint64_t(std::count_if(frame.depth.begin(), frame.depth.end(), [](float z) { return !(z > 0); }));
}

uint64_t covered_pixels(const render::Frame& frame) {
    return uint64_t(
        std::count_if(frame.depth.begin(), frame.depth.end(), [](float z) { return std::isfinite(z); }));
}

render::ImageDifference difference_from_mesh(const Subject& subject, const Picture& picture) {
    render::Frame truth;
    render::MeshRaster(subject.mesh).draw(picture.view, {}, truth);
    return render::compare(picture.frame, truth, picture.view.focal_px);
}

double measured_error_px(const Subject& subject, const Picture& picture) {
    const mesh::SurfaceDistance surface(subject.mesh);
    const render::Frame& frame = picture.frame;
    std::vector<double> worst(size_t(frame.height), 0);
    core::parallel_for(size_t(frame.height), [&](size_t row) {
        for (int x = 0; x < frame.width; ++x) {
            const float z = frame.depth[row * size_t(frame.width) + size_t(x)];
            if (!std::isfinite(z)) continue;
            const glm::dvec3 p = scene::point_of_pixel(picture.view, frame, x, int(row));
            const double d = surface.distance(p, std::numeric_limits<double>::infinity());
            worst[row] = std::max(worst[row], d * picture.view.focal_px / double(z));
        }
    });
    return *std::max_element(worst.begin(), worst.end());
}

double measurement_rounding_px(const Picture& picture) {
    const glm::dvec3& eye = picture.view.eye;
    const double largest = std::max({std::fabs(eye.x), std::fabs(eye.y), std::fabs(eye.z)});
    double nearest = std::numeric_limits<double>::infinity();
    for (const float z : picture.frame.depth) nearest = std::min(nearest, double(z));
    // A few roundings of a world coordinate, and of a depth, which is single precision.
    return picture.view.focal_px * (4 * 0x1p-52 * largest / nearest + 8 * 0x1p-24);
}

}  // namespace stability
