// Any bytes as a model of the original QSplat program: a mesh that holds its invariants, or Error.  Nothing
// else.
#include "core/error.h"
#include "mesh/qsplat.h"
#include "mesh_check.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    const std::span<const std::byte> bytes(reinterpret_cast<const std::byte*>(data), size);
    try {
        const mesh::ReadResult result = mesh::read_qsplat({bytes, "fuzz.qs"}, {true});
        check_invariants(result);
        require(result.mesh.radii.size() == result.mesh.positions.size(), "one radius a point");
    } catch (const core::Error&) {
    }
    return 0;
}
