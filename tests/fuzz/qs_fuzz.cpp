// Any bytes as a model: it can be described, verified and cut for views, or Error.  Nothing else.
//
// Each input is tried as it is, and with its checksums set right, so that what lies behind them is reached.
#include <cmath>
#include <cstring>

#include "core/error.h"
#include "model_bytes.h"
#include "splat/cut.h"
#include "splat/info.h"
#include "splat/verify.h"

namespace {

void check_splats(const geom::SplatBatch& batch) {
    require(batch.count >= 0 && batch.count <= geom::SplatBatch::kCapacity, "a batch holds what it can");
    for (int i = 0; i < batch.count; ++i) {
        require(std::isfinite(batch.x[i]) && std::isfinite(batch.y[i]) && std::isfinite(batch.z[i]),
                "centres are finite");
        require(std::isfinite(batch.radius[i]) && batch.radius[i] >= 0, "radii are finite");
        require(batch.flatness[i] > 0 && batch.flatness[i] <= 1, "flatness is in (0, 1]");
    }
}

void check_triangles(const geom::TriangleBatch& batch) {
    require(batch.count >= 0 && batch.count <= geom::TriangleBatch::kCapacity, "a batch holds what it can");
    for (int i = 0; i < batch.count; ++i)
        for (int k = 0; k < 3; ++k) {
            require(
                std::isfinite(batch.x[k][i]) && std::isfinite(batch.y[k][i]) && std::isfinite(batch.z[k][i]),
                "corners are finite");
            require(std::isfinite(batch.nx[k][i]) && std::isfinite(batch.ny[k][i]) &&
                        std::isfinite(batch.nz[k][i]),
                    "corners' normals are finite");
        }
}

void cut_for_views(const splat::Model& model) {
    const splat::Header& h = model.header();
    for (const double distance : {3.0, 0.5}) {
        geom::Camera camera;
        camera.eye = h.origin + h.scale * distance * glm::dvec3(0.48, 0.6, 0.64);
        camera.target = h.origin;
        splat::Cut cut(model);
        splat::CutOptions options;
        options.threshold_px = distance > 1 ? 0 : 1;
        options.triangle_px = distance > 1 ? 4 : 0;
        const size_t tasks = cut.begin(geom::make_view(camera, 320, 240), options);
        for (size_t t = 0; t < tasks; ++t) cut.run(t, check_splats, nullptr, check_triangles);
        require(cut.counts().splats + cut.counts().triangles <= h.node_count,
                "no more splats and triangles than nodes");
        const splat::CutProfile profile =
            cut.profile(geom::make_view(camera, 320, 240), options, {0, 1e6, 16});
        require(std::isfinite(profile.at(profile.first_step()).splats), "profiles are finite");
    }
}

template <class Use>
void attempt(const Use& use) {
    try {
        use();
    } catch (const core::Error&) {
        // rejecting is fine
    }
}

void use_model(const Bytes& bytes) {
    attempt([&] { splat::verify(memory_file(bytes)); });
    attempt([&] {
        const splat::Model model(memory_file(bytes));
        const splat::Info info = splat::read_info(model);
        splat::to_json(info).dump();
        splat::to_text(info);
    });
    attempt([&] { cut_for_views(splat::Model(memory_file(bytes))); });
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    Bytes bytes(size);
    if (size > 0) std::memcpy(bytes.data(), data, size);
    use_model(bytes);
    repair_checksums(bytes);
    use_model(bytes);
    return 0;
}
