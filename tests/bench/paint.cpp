// paint IN OUT.ply: gives every vertex of a mesh a colour: broad bands, a fine pattern and grain, so that a
// channel of colours has detail at all scales.  Positions and faces stay as they are.
#include <cmath>
#include <cstdio>

#include "core/error.h"
#include "core/file.h"
#include "mesh/mesh.h"

namespace {

// 0..1, different for neighbours.
float grain(uint32_t n) {
    n = (n ^ (n >> 16)) * 0x7feb352du;
    n = (n ^ (n >> 15)) * 0x846ca68bu;
    return float(n >> 16) / 65536.0f;
}

uint8_t byte(float value) {
    return uint8_t(255.0f * std::fmin(std::fmax(value, 0.0f), 1.0f));
}

void paint(mesh::Mesh& mesh) {
    glm::vec3 low(INFINITY), high(-INFINITY);
    for (const glm::vec3& p : mesh.positions) low = glm::min(low, p), high = glm::max(high, p);
    const glm::vec3 extent = high - low;
    const float size = std::fmax(extent.x, std::fmax(extent.y, extent.z));
    mesh.colours.resize(mesh.positions.size());
    for (size_t v = 0; v < mesh.positions.size(); ++v) {
        const glm::vec3 p = size > 0 ? (mesh.positions[v] - low) / size : glm::vec3(0);
        const float broad = 0.5f + 0.5f * std::sin(9 * p.x + 5 * p.y),
                    fine = std::sin(90 * p.y) * std::sin(80 * p.z);
        const float speck = 0.1f * grain(uint32_t(v));
        mesh.colours[v] = {byte(0.3f + 0.5f * broad + speck), byte(0.45f + 0.2f * fine + speck),
                           byte(0.7f - 0.5f * broad + 0.1f * fine + speck)};
    }
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 3) {
        std::fputs("usage: paint IN OUT.ply\n", stderr);
        return 2;
    }
    try {
        mesh::Mesh mesh = mesh::read_mesh(argv[1]).mesh;
        paint(mesh);
        core::OutputFile out(argv[2]);
        out.write(mesh::to_ply(mesh));
        out.commit();
    } catch (const core::Error& error) {
        std::fprintf(stderr, "paint: %s\n", error.what());
        return 1;
    }
}
