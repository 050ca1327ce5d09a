// Any bytes as OBJ, OFF or STL, chosen by the first: a mesh that holds its invariants, or Error.
#include "core/error.h"
#include "mesh_check.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    if (size == 0) return 0;
    const std::string name = data[0] == 'o' ? "fuzz.off" : data[0] == 's' ? "fuzz.stl" : "fuzz.obj";
    const std::span<const std::byte> bytes(reinterpret_cast<const std::byte*>(data + 1), size - 1);
    // Draco's own decoder is not the subject here, and PLY has its own target.
    if (size > 4 && (data[1] == 'D' || (data[1] == 'p' && data[2] == 'l'))) return 0;
    for (const bool skip_bad : {false, true}) {
        try {
            check_invariants(mesh::read_mesh_bytes(bytes, name, {skip_bad}));
        } catch (const core::Error&) {
        }
    }
    return 0;
}
