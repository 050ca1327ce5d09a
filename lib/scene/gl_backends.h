// The back ends of OpenGL, or the reasons why there are none.
#pragma once

#include "scene/backends.h"

namespace scene {

// These throw core::Error where the library, the driver or this build cannot.
Backend open_osmesa();
Backend open_egl();
Backend open_egl_hardware();  // with the reason to take it; never software

}  // namespace scene
