#include "scene/progressive.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <limits>

#include "core/error.h"
#include "net/address.h"
#include "pm/client_mesh.h"
#include "pm/extract.h"
#include "pm/follow.h"
#include "pm/selection.h"
#include "render/raster.h"
#include "render/shading.h"

namespace scene {

namespace {

// Around the box; the model's own vertices touch it.
geom::Sphere sphere_of(const pm::Header& header) {
    const pm::Placement& p = header.placement;
    return {p.world_from_unit(glm::dvec3(0.5)), p.extent * 0.5 * std::sqrt(3.0)};
}

// Of a base vertex of which no more is known: by its error, and not by its radius, since the surface is about
// as far from the base mesh's faces as that.
geom::Sphere sphere_of(const pm::Header& header, const pm::NodeBounds& root, bool is_leaf) {
    const pm::Placement& p = header.placement;
    return {p.world_from_unit(root.centre), is_leaf ? 0 : pm::decode_error(root.error) * p.extent};
}

class FileSource final : public ProgressiveSource {
  public:
    explicit FileSource(const std::string& path)
        : model_(path), selection_(model_), front_(model_.hierarchy()) {}
    geom::Sphere bounds() const override { return sphere_of(model_.header()); }
    std::vector<geom::Sphere> outline() const override {
        std::vector<geom::Sphere> spheres;
        for (uint32_t v = 0; v != model_.vertices(); ++v) spheres.push_back({model_.world(v), 0});
        return spheres;
    }
    bool has_colour() const override { return model_.header().has_colours(); }
    mesh::Mesh mesh_for(const geom::Camera& camera, int width, int height, double threshold_px,
                        ProgressiveCosts& costs, std::optional<double>) override {
        front_.assign(selection_.select(pm::make_view(geom::make_view(camera, width, height), threshold_px)));
        const pm::SelectionCounts& counts = selection_.counts();
        costs = {counts.tested, counts.outside, counts.faces_away, front_.split_count(), 0, 0};
        return pm::mesh_of(model_, front_);
    }

  private:
    pm::Model model_;
    pm::Selection selection_;
    pm::Front front_;
};

class ServerSource final : public ProgressiveSource {
  public:
    ServerSource(const std::string& source, int most_retries)
        : location_(pm::parse_location(source)), most_retries_(most_retries) {}
    geom::Sphere bounds() const override { return sphere_of(follower().state().header()); }
    std::vector<geom::Sphere> outline() const override {
        const pm::Replica& replica = follower().state().replica();
        std::vector<geom::Sphere> spheres;
        for (uint32_t v = 0; v != replica.vertex_count() - replica.split_count(); ++v)
            spheres.push_back(sphere_of(replica.header(), replica.bounds(v), replica.node(v).is_leaf));
        return spheres;
    }
    bool has_colour() const override { return follower().state().header().has_colours(); }
    mesh::Mesh mesh_for(const geom::Camera& camera, int width, int height, double threshold_px,
                        ProgressiveCosts& costs, std::optional<double> patience_s) override {
        follower().look_through(width, height, threshold_px);
        if (patience_s) follower().wait_at_most(*patience_s);
        const pm::FrameCosts spent = follower().show(frame_++, camera);
        costs.is_complete = spent.is_complete;
        costs.splits = spent.splits;
        costs.bytes_up = spent.bytes_up, costs.bytes_down = spent.bytes_down;
        return pm::mesh_of(follower().state().replica(), follower().front());
    }

  private:
    pm::Follower& follower() const {
        if (!follower_) {
            pm::FollowOptions options;
            options.most_retries = most_retries_;
            follower_ = std::make_unique<pm::Follower>(pm::connector(location_.address, options.timeout_s),
                                                       location_.name, options);
        }
        return *follower_;
    }

    pm::Location location_;
    int most_retries_;
    mutable std::unique_ptr<pm::Follower> follower_;
    int frame_ = 0;
};

// In the picture, of triangle `i`; infinite where it reaches behind the eye.
float longest_side_px(const geom::View& view, const geom::TriangleBatch& batch, int i) {
    glm::vec2 at[3];
    for (int k = 0; k != 3; ++k) {
        const float depth = batch.z[k][i];
        if (!(depth > 0)) return std::numeric_limits<float>::infinity();
        at[k] = float(view.focal_px) * glm::vec2(batch.x[k][i], batch.y[k][i]) / depth;
    }
    return std::max({glm::distance(at[0], at[1]), glm::distance(at[1], at[2]), glm::distance(at[2], at[0])});
}

// From vertices to the triangles of batches, in the view's space.
class BatchMaker {
  public:
    BatchMaker(const mesh::Mesh& mesh, const geom::View& view, bool shows_sizes,
               render::SplatPainter& painter)
        : mesh_(mesh),
          view_(view),
          shows_sizes_(shows_sizes),
          painter_(painter),
          normals_(render::filled_normals(mesh)) {}

    void add(const glm::u32vec3& face) {
        glm::vec3 normals[3];
        glm::uvec3 colour(0);
        for (int k = 0; k != 3; ++k) {
            const uint32_t v = face[k];
            const glm::vec3 p(view_.view_from_world(mesh_.origin + glm::dvec3(mesh_.positions[v])));
            const glm::dvec3 n(normals_[v]);
            normals[k] =
                glm::vec3(glm::dot(view_.right, n), glm::dot(view_.down, n), glm::dot(view_.forward, n));
            batch_.x[k][batch_.count] = p.x, batch_.y[k][batch_.count] = p.y, batch_.z[k][batch_.count] = p.z;
            batch_.nx[k][batch_.count] = normals[k].x, batch_.ny[k][batch_.count] = normals[k].y;
            batch_.nz[k][batch_.count] = normals[k].z;
            if (!mesh_.colours.empty()) colour += glm::uvec3(mesh_.colours[v]);
        }
        colour = (colour + 1u) / 3u;
        if (shows_sizes_)
            colour = glm::uvec3(render::level_colour(longest_side_px(view_, batch_, batch_.count)));
        batch_.colour[batch_.count] = colour.x | colour.y << 8 | colour.z << 16;
        if (++batch_.count == geom::TriangleBatch::kCapacity) flush();
    }
    void flush() {
        if (batch_.count > 0) painter_.add(0, batch_);
        batch_.count = 0;
    }

  private:
    const mesh::Mesh& mesh_;
    const geom::View& view_;
    bool shows_sizes_;
    render::SplatPainter& painter_;
    std::vector<glm::vec3> normals_;
    geom::TriangleBatch batch_;
};

}  // namespace

bool is_progressive(const std::string& source) {
    if (pm::is_location(source)) return true;
    std::error_code unknown;
    if (!std::filesystem::is_regular_file(source, unknown)) return false;
    std::array<char, sizeof pm::kMagic> magic = {};
    std::ifstream file(source, std::ios::binary);
    file.read(magic.data(), magic.size());
    return file && pm::is_model(std::as_bytes(std::span(magic)));
}

std::unique_ptr<ProgressiveSource> open_progressive(const std::string& source, int most_retries) {
    if (pm::is_location(source)) return std::make_unique<ServerSource>(source, most_retries);
    return std::make_unique<FileSource>(source);
}

void draw_mesh(const mesh::Mesh& mesh, const geom::View& view, const render::Look& look,
               render::SplatPainter& painter, render::Frame& frame) {
    render::SplatterOptions options;
    options.look = look;
    // What is a leaf to the painter is a triangle of any size here.
    const bool shows_sizes = look.shade == render::Shade::level;
    if (shows_sizes) options.look.shade = render::Shade::lit;
    options.has_colour = shows_sizes || !mesh.colours.empty();
    options.has_triangles = true;
    painter.begin(view, options, 1);
    auto maker = std::make_unique<BatchMaker>(mesh, view, shows_sizes, painter);
    for (const glm::u32vec3& face : mesh.triangles) maker->add(face);
    maker->flush();
    painter.end_task(0);
    painter.finish(frame);
}

}  // namespace scene
