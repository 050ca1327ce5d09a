#include "scene/model_file.h"

#include "core/error.h"
#include "core/program.h"
#include "core/stopwatch.h"
#include "mesh/qsplat.h"
#include "splat/build.h"

namespace scene {

core::InputFile open_model_file(const std::string& path) {
    core::InputFile file(path);
    const mesh::Source source{file.bytes(), file.name(), &file};
    if (!mesh::is_qsplat(source)) return file;
    core::Stopwatch watch;
    core::OutputFile model(core::OutputFile::InMemory{file.name()});
    splat::build(mesh::read_qsplat(source, {}).mesh, {}, model, file.name());
    core::notice(
        core::text("%s: a model of the original QSplat, made into one of ours in %.0f ms; qs-build does this "
                   "once for all",
                   file.name().c_str(), watch.lap_ms()));
    return model.read_back();
}

}  // namespace scene
