// coral: make the model that the demo shows, a piece of coral reef, as a binary PLY with colours.
#include <cstring>
#include <string>

#include "coral/surface_net.h"
#include "core/error.h"
#include "core/file.h"
#include "core/program.h"

namespace {

template <class T>
void append(std::string& bytes, const T& value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof(T));
}

std::string to_ply(const coral::ColouredMesh& mesh) {
    std::string ply = core::text(
        "ply\nformat binary_little_endian 1.0\n"
        "element vertex %zu\nproperty float x\nproperty float y\nproperty float z\n"
        "property uchar red\nproperty uchar green\nproperty uchar blue\n"
        "element face %zu\nproperty list uchar int vertex_indices\nend_header\n",
        mesh.positions.size(), mesh.triangles.size());
    ply.reserve(ply.size() + 15 * mesh.positions.size() + 13 * mesh.triangles.size());
    for (size_t v = 0; v < mesh.positions.size(); ++v) {
        append(ply, mesh.positions[v]);
        append(ply, mesh.colours[v]);
    }
    for (const glm::u32vec3& triangle : mesh.triangles) {
        ply += '\3';
        append(ply, triangle);
    }
    return ply;
}

}  // namespace

int main(int argc, char** argv) {
    core::Program program("coral", "Make a piece of coral reef as a binary PLY with colours.", QS_VERSION);
    int64_t resolution = 512;
    std::string output = "-";
    program.add_integer("--resolution", resolution, 64, 4096,
                        "Lattice cells along the longest side; triangles go with its square");
    CLI::Option* output_option =
        program.options.add_option("-o,--output", output, "The PLY file; - is standard output");

    return program.run(argc, argv, [&] {
        if (output == "-") core::refuse_binary_to_terminal(output_option->count() > 0);
        core::Report report({}, {output});
        const coral::Reef reef;
        const coral::ColouredMesh mesh = coral::triangulate(reef, static_cast<int>(resolution));
        core::OutputFile file(output);
        file.write(to_ply(mesh));
        file.commit();
        report.write({{"vertices", mesh.positions.size()}, {"triangles", mesh.triangles.size()}});
        report.commit();
    });
}
