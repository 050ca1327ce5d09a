// Any bytes as a progressive mesh: it can be described, verified, selected from and extracted, or Error.
// Nothing else.
//
// Each input is tried as it is, and with its checksums set right, so that what lies behind them is reached.
#include <cmath>
#include <cstring>

#include "core/error.h"
#include "model_bytes.h"
#include "pm/extract.h"
#include "pm/info.h"
#include "pm/selection.h"
#include "pm/verify.h"

namespace {

void use_model(const Bytes& bytes) {
    try {
        const pm::Model model(memory_file(bytes));
        pm::to_json(pm::read_info(model)).dump();
        pm::Selection selection(model);
        pm::Front front(model.hierarchy());
        for (const uint32_t d : selection.select(pm::View{})) {
            require(front.can_split(d), "what a view wants is closed");
            front.split(d);
        }
        const mesh::Mesh mesh = pm::mesh_of(model, front);
        for (const glm::u32vec3& face : mesh.triangles)
            for (int k = 0; k < 3; ++k) require(face[k] < mesh.positions.size(), "corners are vertices");
        pm::verify(model);
    } catch (const core::Error&) {
        // rejecting is fine
    }
}

void repair(Bytes& bytes) {
    if (bytes.size() < pm::kHeaderSize) return;
    const uint64_t content = XXH3_64bits(bytes.data() + pm::kHeaderSize, bytes.size() - pm::kHeaderSize);
    std::memcpy(bytes.data() + 128, &content, 8);
    const uint64_t sum = XXH3_64bits(bytes.data(), pm::kHeaderSize - 8);
    std::memcpy(bytes.data() + pm::kHeaderSize - 8, &sum, 8);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    Bytes bytes(size);
    if (size > 0) std::memcpy(bytes.data(), data, size);
    use_model(bytes);
    repair(bytes);
    use_model(bytes);
    return 0;
}
