#include "ppve/sample/embree_sampler.h"

#include <embree3/rtcore.h>

#include <cmath>

#include "core/error.h"
#include "core/parallel.h"
#include "core/stopwatch.h"
#include "ppve/sample/light.h"
#include "ppve/sample/pixel_rays.h"
#include "render/raster.h"
#include "render/shading.h"

namespace ppve {

namespace {

struct ReleaseDevice {
    void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
};
struct ReleaseScene {
    void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
};

class EmbreeSampler final : public Sampler {
  public:
    explicit EmbreeSampler(mesh::Mesh mesh)
        : mesh_(std::move(mesh)), normals_(render::filled_normals(mesh_)), device_(rtcNewDevice(nullptr)) {
        if (!device_) throw core::Error("Embree cannot start");
        scene_.reset(rtcNewScene(device_.get()));
        rtcSetSceneFlags(scene_.get(), RTC_SCENE_FLAG_ROBUST);
        const RTCGeometry geometry = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
        auto* at = static_cast<glm::vec3*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0,
                                                                   RTC_FORMAT_FLOAT3, sizeof(glm::vec3),
                                                                   mesh_.positions.size()));
        auto* corners = static_cast<glm::u32vec3*>(
            rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                    sizeof(glm::u32vec3), mesh_.triangles.size()));
        if (at == nullptr || corners == nullptr) throw core::Error("Embree has no memory for the mesh");
        std::copy(mesh_.positions.begin(), mesh_.positions.end(), at);
        std::copy(mesh_.triangles.begin(), mesh_.triangles.end(), corners);
        rtcCommitGeometry(geometry);
        rtcAttachGeometry(scene_.get(), geometry);
        rtcReleaseGeometry(geometry);
        rtcCommitScene(scene_.get());
        if (rtcGetDeviceError(device_.get()) != RTC_ERROR_NONE)
            throw core::Error("Embree cannot take the mesh");
        for (size_t v = 0; v < mesh_.positions.size(); ++v) box_.add(mesh_.world(v));
    }

    std::string name() const override { return "embree"; }
    Box bounds() const override { return box_; }

    SampleCounts sample(DepthImage& image, bool with_normals) override {
        core::Stopwatch watch;
        image.clear(with_normals);
        const DepthRange range = depths_in(image.frustum, box_);
        core::parallel_for(range.is_empty ? 0 : size_t(image.height()), [&](size_t j) {
            for (int i = 0; i < image.width(); ++i) cast(range, image, i, int(j));
        });
        SampleCounts counts;
        counts.bytes = counts.bytes_touched =
            mesh_.positions.size() * sizeof(glm::vec3) + mesh_.triangles.size() * sizeof(glm::u32vec3);
        counts.clusters = counts.clusters_touched = 1;
        counts.triangles_tested = mesh_.triangles.size(), counts.ms = watch.lap_ms();
        return counts;
    }

  private:
    void cast(const DepthRange& range, DepthImage& image, int i, int j) const {
        const PixelRay ray = pixel_ray(image.frustum, i, j);
        // From where the box begins, so that single precision counts from near the surface.
        const DepthInterval inside = clip(ray, box_.low, box_.high, {range.nearest, range.farthest});
        if (!(inside.first <= inside.last)) return;
        const glm::vec3 from(ray.origin + ray.direction * inside.first - mesh_.origin);
        const glm::vec3 along(ray.direction);
        RTCRayHit hit{};
        hit.ray.org_x = from.x, hit.ray.org_y = from.y, hit.ray.org_z = from.z;
        hit.ray.dir_x = along.x, hit.ray.dir_y = along.y, hit.ray.dir_z = along.z;
        hit.ray.tfar = float(range.farthest - inside.first), hit.ray.mask = ~0u;
        hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        rtcIntersect1(scene_.get(), &context, &hit);
        if (hit.hit.geomID == RTC_INVALID_GEOMETRY_ID) return;
        const glm::u32vec3 t = mesh_.triangles[hit.hit.primID];
        const glm::vec3 weights(1 - hit.hit.u - hit.hit.v, hit.hit.u, hit.hit.v);
        const size_t pixel = size_t(j) * size_t(image.width()) + size_t(i);
        image.depth[pixel] = image.coding.code(inside.first + double(hit.ray.tfar));
        image.colour[pixel] = colour_at(t, weights, image.normal.empty());
        if (!image.normal.empty()) image.normal[pixel] = octahedral_code(mixed(normals_, t, weights));
    }

    template <class T>
    static glm::vec3 mixed(const std::vector<T>& of, const glm::u32vec3& t, const glm::vec3& w) {
        return w.x * glm::vec3(of[t.x]) + w.y * glm::vec3(of[t.y]) + w.z * glm::vec3(of[t.z]);
    }

    // Lit at the corners, as the other samplers do it.
    uint32_t colour_at(const glm::u32vec3& t, const glm::vec3& weights, bool is_lit) const {
        glm::vec3 sum(0);
        for (int k = 0; k < 3; ++k) {
            const glm::vec3 material =
                mesh_.colours.empty() ? glm::vec3(render::kGreyMaterial) : glm::vec3(mesh_.colours[t[k]]);
            const uint32_t colour = is_lit ? lit_colour(material, normals_[t[k]]) : pack_colour(material);
            sum +=
                weights[k] * glm::vec3(float(colour & 0xff), float(colour >> 8 & 0xff), float(colour >> 16));
        }
        return pack_colour(sum);
    }

    mesh::Mesh mesh_;
    std::vector<glm::vec3> normals_;
    std::unique_ptr<std::remove_pointer_t<RTCDevice>, ReleaseDevice> device_;
    std::unique_ptr<std::remove_pointer_t<RTCScene>, ReleaseScene> scene_;
    Box box_;
};

}  // namespace

std::unique_ptr<Sampler> open_embree_sampler(mesh::Mesh mesh) {
    if (mesh.is_cloud()) throw core::Error("Embree samples triangles, not points: take --sampler raster");
    return std::make_unique<EmbreeSampler>(std::move(mesh));
}

}  // namespace ppve
