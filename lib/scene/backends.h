// The back ends that there are, by name.
#pragma once

#include <memory>
#include <string>

#include "render/backend.h"

namespace scene {

// cpu: render::Splatter.  osmesa, egl: gl::SplatPainter on a context of theirs, of hardware or not.
// automatic: egl where it finds a graphics processor, else cpu.
enum class BackendKind { automatic, cpu, osmesa, egl };

struct Backend {
    std::unique_ptr<render::SplatPainter> painter;
    std::string name;    // "cpu", "osmesa" or "egl"
    std::string is;      // "llvmpipe (LLVM 15.0.6, 256 bits), OpenGL 3.3 ...", for people
    std::string reason;  // why automatic took it; empty for what was asked for by name
};

// Throws core::Error with the reason where `kind` cannot be had; automatic always can.  Some 50 ms for those
// of OpenGL (the first time more: they load a compiler), 5 ms for automatic where there is no graphics
// processor.
Backend open_backend(BackendKind kind);

// What there is: a line each of its name and what it is, or why it is not there; last, what `auto` takes.
std::string list_backends();

}  // namespace scene
