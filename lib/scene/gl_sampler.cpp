#include "scene/gl_sampler.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/parallel.h"
#include "core/stopwatch.h"
#include "gl/mesh_painter.h"
#include "ppve/sample/light.h"
#include "render/raster.h"
#include "render/shading.h"

namespace scene {

namespace {

constexpr size_t kGrain = 1 << 14;  // pixels handed to a thread at a time

std::unique_ptr<gl::Device> open_device(bool osmesa) {
    if (osmesa) return std::make_unique<gl::Device>(gl::make_osmesa_context());
    try {
        return std::make_unique<gl::Device>(gl::make_egl_context(gl::EglPlatform::device));
    } catch (const core::Error&) {
        // Without a device Mesa has still its software; its own message says why not.
        return std::make_unique<gl::Device>(gl::make_egl_context(gl::EglPlatform::surfaceless));
    }
}

// The mesh with the colours that its light gives it.
mesh::Mesh lit(const mesh::Mesh& mesh, const std::vector<glm::vec3>& normals) {
    mesh::Mesh out = mesh;
    out.colours.resize(mesh.positions.size());
    for (size_t v = 0; v < out.colours.size(); ++v) {
        const glm::vec3 material =
            mesh.colours.empty() ? glm::vec3(render::kGreyMaterial) : glm::vec3(mesh.colours[v]);
        const uint32_t colour = ppve::lit_colour(material, normals[v]);
        out.colours[v] = {uint8_t(colour), uint8_t(colour >> 8), uint8_t(colour >> 16)};
    }
    return out;
}

// Normals as colours, which are drawn as they are; 7 bits of each component are left of them.
mesh::Mesh painted_with(const mesh::Mesh& mesh, const std::vector<glm::vec3>& normals) {
    mesh::Mesh out = mesh;
    out.colours.resize(mesh.positions.size());
    for (size_t v = 0; v < out.colours.size(); ++v)
        out.colours[v] = glm::u8vec3(glm::clamp(127.5f + 127.0f * normals[v] + 0.5f, 0.0f, 255.0f));
    return out;
}

class GlSampler final : public ppve::Sampler {
  public:
    GlSampler(mesh::Mesh mesh, bool osmesa)
        : name_(osmesa ? "osmesa" : "egl"), osmesa_(osmesa), mesh_(std::move(mesh)) {
        if (mesh_.is_cloud())
            throw core::Error("OpenGL samples triangles, not points: take --sampler raster");
        normals_ = render::filled_normals(mesh_);
        for (size_t v = 0; v < mesh_.positions.size(); ++v) box_.add(mesh_.world(v));
        lit_ = lit(mesh_, normals_);
        painter_ = std::make_unique<gl::MeshPainter>(open_device(osmesa), lit_);
    }

    std::string name() const override { return name_; }
    ppve::Box bounds() const override { return box_; }

    ppve::SampleCounts sample(ppve::DepthImage& image, bool with_normals) override {
        if (image.frustum.projection != ppve::Projection::perspective)
            throw core::Error("OpenGL samples perspective frusta only: take --sampler raster");
        core::Stopwatch watch;
        image.clear(with_normals);
        render::Frame frame;
        if (with_normals) {
            open_painters_of_normals();
            painted_painter_->draw(image.frustum.view, {.shade = render::Shade::flat}, frame);
            core::parallel_pieces(image.pixels(), kGrain, [&](size_t begin, size_t end) {
                for (size_t p = begin; p < end; ++p)
                    if (std::isfinite(frame.depth[p])) image.normal[p] = normal_of(&frame.rgb[3 * p]);
            });
            material_painter_->draw(image.frustum.view, {.shade = render::Shade::flat}, frame);
        } else {
            painter_->draw(image.frustum.view, {.shade = render::Shade::flat}, frame);
        }
        core::parallel_pieces(image.pixels(), kGrain, [&](size_t begin, size_t end) {
            for (size_t p = begin; p < end; ++p) {
                if (!std::isfinite(frame.depth[p])) continue;
                image.depth[p] = image.coding.code(double(frame.depth[p]));
                const uint8_t* rgb = &frame.rgb[3 * p];
                image.colour[p] = uint32_t(rgb[0] | rgb[1] << 8 | rgb[2] << 16);
            }
        });
        const uint64_t bytes =
            mesh_.positions.size() * sizeof(glm::vec3) + mesh_.triangles.size() * sizeof(glm::u32vec3);
        ppve::SampleCounts counts;
        counts.bytes = counts.bytes_touched = bytes, counts.clusters = counts.clusters_touched = 1;
        counts.triangles_tested = mesh_.triangles.size(), counts.ms = watch.lap_ms();
        return counts;
    }

  private:
    static uint16_t normal_of(const uint8_t* rgb) {
        return ppve::octahedral_code(glm::vec3(float(rgb[0]), float(rgb[1]), float(rgb[2])) - 127.5f);
    }

    void open_painters_of_normals() {
        if (painted_painter_) return;
        painted_ = painted_with(mesh_, normals_);
        painted_painter_ = std::make_unique<gl::MeshPainter>(open_device(osmesa_), painted_);
        material_painter_ = std::make_unique<gl::MeshPainter>(open_device(osmesa_), mesh_);
    }

    std::string name_;
    bool osmesa_;
    mesh::Mesh mesh_, lit_, painted_;
    std::vector<glm::vec3> normals_;
    ppve::Box box_;
    // Those of normals are opened when normals are asked for first.
    std::unique_ptr<gl::MeshPainter> painter_, painted_painter_, material_painter_;
};

}  // namespace

std::unique_ptr<ppve::Sampler> open_gl_sampler(mesh::Mesh mesh, bool osmesa) {
    return std::make_unique<GlSampler>(std::move(mesh), osmesa);
}

}  // namespace scene
