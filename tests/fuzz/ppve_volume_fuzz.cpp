// Any text as the header of a volume: one whose numbers are in range, or Error.  Nothing else.
#include <cmath>
#include <cstdint>
#include <string_view>

#include "core/error.h"
#include "ppve/sample/volume.h"
#include "require.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    const std::string_view text(reinterpret_cast<const char*>(data), size);
    try {
        const ppve::VolumeHeader h = ppve::parse_volume_header(text, "fuzz");
        for (int k = 0; k < 3; ++k) {
            require(h.size[k] >= 2 && h.size[k] <= ppve::VolumeHeader::kMostSamples, "a size is in range");
            require(h.spacing[k] > 0 && std::isfinite(h.spacing[k]) && std::isfinite(h.offset[k]),
                    "a place is in range");
        }
        require(h.data_file.find('/') == std::string::npos, "the data lie beside the header");
    } catch (const core::Error&) {
    }
    return 0;
}
