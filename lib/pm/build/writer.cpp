#include "pm/build/writer.h"

#include <xxhash.h>

#include <cstring>
#include <memory>

namespace pm {

namespace {

// Hashes or writes one section after the other, each padded to 8 bytes.
template <class Sink>
void for_sections(const Header& header, const Details& d, const VertexData& v, std::span<const Weld> welds,
                  const Sink& sink) {
    const auto put = [&](const void* data, size_t size) {
        static constexpr std::byte kZeros[8]{};
        sink(data, size);
        sink(kZeros, (8 - size % 8) % 8);
    };
    const auto put_all = [&](const auto& values) { put(values.data(), values.size() * sizeof(values[0])); };
    put_all(d.base_faces);
    put_all(d.root_split);
    put_all(d.kept);
    put_all(d.parent);
    put_all(d.needs);
    put_all(d.children);
    put_all(d.faces);
    std::vector<uint16_t> axes;
    std::vector<uint8_t> angles;
    for (const ConeCodes& cone : d.cones) axes.push_back(cone.axis), angles.push_back(cone.angle);
    put_all(axes);
    put_all(angles);
    put_all(d.error);
    put_all(d.radius);
    if (header.is_lossless()) {
        put_all(v.single);
    } else if (header.position_bytes() == 12) {
        put_all(v.lattice);
    } else {
        put_all(std::vector<glm::u16vec3>(v.lattice.begin(), v.lattice.end()));
    }
    put_all(v.normals);
    put_all(v.colours);
    put_all(welds);
}

}  // namespace

void write_model(Header& header, const Details& details, const VertexData& vertices,
                 std::span<const Weld> welds, core::OutputFile& out) {
    const std::unique_ptr<XXH3_state_t, decltype(&XXH3_freeState)> hash(XXH3_createState(), XXH3_freeState);
    XXH3_64bits_reset(hash.get());
    for_sections(header, details, vertices, welds,
                 [&](const void* data, size_t size) { XXH3_64bits_update(hash.get(), data, size); });
    header.content_hash = XXH3_64bits_digest(hash.get());
    out.write(encode_header(header));
    for_sections(header, details, vertices, welds, [&](const void* data, size_t size) {
        if (size > 0) out.write(data, size);
    });
}

}  // namespace pm
