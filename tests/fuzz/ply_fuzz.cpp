// Any bytes as PLY: a mesh that holds its invariants, or Error.  Nothing else.
#include "core/error.h"
#include "mesh_check.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    const std::span<const std::byte> bytes(reinterpret_cast<const std::byte*>(data), size);
    for (const bool skip_bad : {false, true}) {
        try {
            check_invariants(mesh::read_mesh_bytes(bytes, "fuzz.ply", {skip_bad}));
        } catch (const core::Error&) {
        }
    }
    return 0;
}
