// Stands in for draco.cpp in a build without QS_DRACO.
#include "core/error.h"
#include "mesh/draco.h"

namespace mesh {

ReadResult read_draco(const Source& source, const ReadOptions&) {
    throw core::Error(source.name + ": header: this build cannot read Draco");
}

}  // namespace mesh
