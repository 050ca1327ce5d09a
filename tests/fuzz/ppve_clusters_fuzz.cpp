// Any bytes as a file of clusters, as they are and with the checksum of the table set right: images of it, or
// Error. Nothing else.
#include <xxhash.h>

#include <cstring>

#include "core/error.h"
#include "model_bytes.h"
#include "ppve/sample/raster_sampler.h"

namespace {

void use(const Bytes& bytes) {
    try {
        ppve::RasterSampler sampler{ppve::Clusters(memory_file(bytes))};
        const ppve::Box box = sampler.bounds();
        ppve::DepthImage image;
        geom::View& view = image.frustum.view;
        view.width = 24, view.height = 16, view.focal_px = 20, view.eye = 0.5 * (box.low + box.high);
        ppve::prepare(sampler, 0.01, image);
        sampler.sample(image, true);
        require(image.depth.size() == image.pixels(), "an image has the size of its frustum");
    } catch (const core::Error&) {
    }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    Bytes bytes(size);
    if (size > 0) std::memcpy(bytes.data(), data, size);
    use(bytes);
    uint32_t count = 0;
    constexpr size_t kHeader = 64, kEntry = 48;
    if (size < kHeader) return 0;
    std::memcpy(&count, bytes.data() + 12, sizeof(count));
    const uint64_t table = kHeader + kEntry * uint64_t(count);
    if (table + 8 > size) return 0;
    // Of the clusters as well, so that what is in them is reached.
    for (uint64_t c = 0; c < count; ++c) {
        std::byte* entry = bytes.data() + kHeader + kEntry * c;
        uint32_t vertices, triangles;
        uint64_t offset;
        std::memcpy(&vertices, entry + 24, 4), std::memcpy(&triangles, entry + 28, 4),
            std::memcpy(&offset, entry + 32, 8);
        const uint64_t length = (uint64_t(vertices) + 7) / 8 * 8 * 22 + uint64_t(triangles) * 6;
        if (offset > size || length > size - offset) continue;
        const uint64_t sum = XXH3_64bits(bytes.data() + offset, length);
        std::memcpy(entry + 40, &sum, 8);
    }
    const uint64_t sum = XXH3_64bits(bytes.data(), table);
    std::memcpy(bytes.data() + table, &sum, 8);
    use(bytes);
    return 0;
}
