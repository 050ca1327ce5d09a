#include "scene/backends.h"

#include "core/error.h"
#include "render/splatter.h"
#include "render/tile.h"
#include "scene/gl_backends.h"

namespace scene {
namespace {

Backend open_cpu(const std::string& reason) {
    return {std::make_unique<render::Splatter>(), "cpu",
            std::string("our own splatter, ") + render::instruction_set(), reason};
}

Backend open_automatic() {
    try {
        return open_egl_hardware();
    } catch (const core::Error& error) {
        return open_cpu(error.what());
    }
}

std::string line(const std::string& name, const std::string& text) {
    return core::text("%-7s %s\n", name.c_str(), text.c_str());
}

std::string line_of(const std::string& name, BackendKind kind) {
    try {
        return line(name, open_backend(kind).is);
    } catch (const core::Error& error) {
        return line(name, std::string("not there: ") + error.what());
    }
}

}  // namespace

Backend open_backend(BackendKind kind) {
    switch (kind) {
        case BackendKind::automatic:
            return open_automatic();
        case BackendKind::osmesa:
            return open_osmesa();
        case BackendKind::egl:
            return open_egl();
        case BackendKind::cpu:
            break;
    }
    return open_cpu("");
}

std::string list_backends() {
    const Backend taken = open_backend(BackendKind::automatic);
    return line_of("cpu", BackendKind::cpu) + line_of("osmesa", BackendKind::osmesa) +
           line_of("egl", BackendKind::egl) + line("auto", "takes " + taken.name + ": " + taken.reason);
}

}  // namespace scene
