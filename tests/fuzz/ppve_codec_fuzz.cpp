// Any bytes as a coded depth image of a size that the first bytes say: an image that is coded as the same
// again, or Error. Nothing else.
#include <cstring>
#include <span>

#include "core/error.h"
#include "ppve/codec.h"
#include "require.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    if (size < 3) return 0;
    ppve::DepthImage image;
    image.frustum.view.width = 1 + data[0], image.frustum.view.height = 1 + data[1];
    const auto codec = ppve::Codec(data[2] & 1);
    const bool has_normals = (data[2] & 2) != 0;
    try {
        ppve::decode(std::as_bytes(std::span(data + 3, size - 3)), codec, has_normals, image);
        ppve::DepthImage again;
        again.frustum = image.frustum;
        ppve::decode(ppve::encode(image, codec), codec, has_normals, again);
        require(again.depth == image.depth && again.colour == image.colour && again.normal == image.normal,
                "codecs are lossless");
    } catch (const core::Error&) {
    }
    return 0;
}
