#include "scene/model_file.h"

#include <algorithm>
#include <array>

#include "core/error.h"
#include "core/messages.h"
#include "core/stopwatch.h"
#include "mesh/qsplat.h"
#include "splat/build.h"
#include "splat/format.h"

namespace scene {

namespace {

bool is_named_as_mesh(const std::string& path) {
    constexpr std::array kEndings{".ply", ".obj", ".off", ".stl", ".drc"};
    std::string end = path.substr(path.size() - std::min<size_t>(path.size(), 4));
    for (char& c : end) c = c >= 'A' && c <= 'Z' ? char(c - 'A' + 'a') : c;
    return std::any_of(kEndings.begin(), kEndings.end(), [&](const char* ending) { return end == ending; });
}

}  // namespace

core::InputFile open_model_file(const std::string& path) {
    core::InputFile file(path);
    const mesh::Source source{file.bytes(), file.name(), &file};
    const bool is_qsplat = mesh::is_qsplat(source);
    if (splat::is_model(file.bytes()) || (!is_qsplat && !is_named_as_mesh(path))) return file;
    core::Stopwatch watch;
    const std::string name = file.name();
    core::OutputFile model(core::OutputFile::InMemory{name});
    mesh::Mesh mesh = is_qsplat ? mesh::read_qsplat(source, {}).mesh : mesh::read_mesh(std::move(file)).mesh;
    splat::BuildOptions options;
    if (!is_qsplat && !mesh.is_cloud()) options.leaf = splat::Leaf::triangle;
    splat::build(std::move(mesh), options, model, name);
    core::notice(core::text("%s: a %s, made into a model in %.0f ms; qs-build does this once for all",
                            name.c_str(), is_qsplat ? "model of the original QSplat" : "mesh",
                            watch.lap_ms()));
    return model.read_back();
}

}  // namespace scene
