// Views that a user saved of a source, kept from one window to the next.
//
// Each view is a file of its own, a camera path of one line, camera-path(5), in a folder for the source:
//
//     $XDG_STATE_HOME/qs-view/scan.qs-3f2a90c1d07b11e4/1.jsonl
//
// so that two windows of one source overwrite no more than the view that both save.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "geom/camera.h"

namespace view {

using SavedViews = std::array<std::optional<geom::Camera>, 9>;

// The folder for the views of these sources, whether it is there or not; below ~/.local/state where
// XDG_STATE_HOME names none.  Named after the first source, and by a hash of what all are: addresses as they
// are, files by their absolute names without links, so that a source is the same from wherever it is named.
// Throws core::Error where HOME names no folder either.
std::string views_folder(const std::vector<std::string>& sources);

// `number`, here and below: an index of SavedViews.  None where it was not saved.  Throws core::Error for a
// file that is no path of one camera.
std::optional<geom::Camera> read_view(const std::string& folder, size_t number);

// Makes the folder and what is missing above it, open to nobody else; the file
// is there whole or not at all.  Returns its name.  Throws core::Error.
std::string write_view(const std::string& folder, size_t number, const geom::Camera& camera);

}  // namespace view
