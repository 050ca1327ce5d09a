#include "scene/surface_file.h"

#include "core/error.h"
#include "core/file.h"
#include "splat/build/cloud.h"
#include "splat/extract.h"
#include "splat/format.h"
#include "splat/model.h"

namespace scene {

namespace {

// The finest that there is of a model: its last level.
mesh::Mesh leaves_of(core::InputFile file) {
    const splat::Model model(std::move(file));
    core::OutputFile leaves(core::OutputFile::InMemory{model.name()});
    splat::write_cut(model, model.header().level_count, leaves);
    return mesh::read_mesh(leaves.read_back()).mesh;
}

mesh::Mesh read_surface(const std::string& path) {
    core::InputFile file(path);
    mesh::Mesh mesh =
        splat::is_model(file.bytes()) ? leaves_of(std::move(file)) : mesh::read_mesh(std::move(file)).mesh;
    if (mesh.is_cloud() && mesh.radii.empty()) mesh.radii = splat::estimate_discs(mesh);
    return mesh;
}

template <class T>
void append(std::vector<T>& to, size_t count_before, const std::vector<T>& from, size_t count,
            const T& missing) {
    if (to.empty() && from.empty()) return;
    to.resize(count_before, missing);
    to.insert(to.end(), from.begin(), from.end());
    to.resize(count_before + count, missing);
}

void append(mesh::Mesh& to, const mesh::Mesh& from) {
    const size_t before = to.positions.size(), count = from.positions.size();
    if (before + count > ~uint32_t(0)) throw core::Error("more vertices than triangles can name");
    const glm::dvec3 offset = from.origin - to.origin;
    for (const glm::vec3& p : from.positions) to.positions.push_back(glm::vec3(glm::dvec3(p) + offset));
    constexpr uint8_t kGrey = 230;
    append(to.normals, before, from.normals, count, glm::vec3(0));
    append(to.colours, before, from.colours, count, glm::u8vec3(kGrey));
    append(to.radii, before, from.radii, count, 0.0f);
    for (const glm::u32vec3& t : from.triangles) to.triangles.push_back(t + uint32_t(before));
}

}  // namespace

mesh::Mesh read_surfaces(std::span<const std::string> paths) {
    mesh::Mesh all = read_surface(paths.front());
    for (const std::string& path : paths.subspan(1)) {
        const mesh::Mesh more = read_surface(path);
        if (more.is_cloud() != all.is_cloud())
            throw core::Error(path + ": points and triangles together cannot be sampled; " + paths.front() +
                              " has the other");
        append(all, more);
    }
    return all;
}

}  // namespace scene
