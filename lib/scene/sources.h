// The models of a command line and where they stand.
#pragma once

#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "geom/similarity.h"
#include "scene/draw.h"
#include "scene/remote_models.h"
#include "splat/model.h"

namespace scene {

// One SOURCE: a file or a URL, or FILE@TRANSFORM.  TRANSFORM is numbers with commas between, as
// parse_similarity() takes them, or a file of such numbers whose name ends in .xf.  What stands after the
// last @ and is neither belongs to the file's name.
struct Source {
    std::string file;
    std::string transform_file;  // empty: none
    geom::Similarity world_from_model{};
    bool is_placed = false;
};

// Reads the files of transforms.  Throws core::UsageError for wrong numbers on the command line and where two
// models are standard input, core::Error for a file that cannot be read or is wrong.
std::vector<Source> parse_sources(const std::vector<std::string>& words);

// The models of the sources; a file that stands there twice is opened once.
class Models {
  public:
    // What is waited for of a model that arrives.
    struct Beginning {
        bool needs_first_picture = true;  // 13 KiB; else a block, which draws little more than a blob
        bool needs_outline = false;       // what scene::outline_of() reads
    };

    // `cache`: the folder of qs-fetch's cache for those that are URLs; empty: its default.
    Models(const std::vector<Source>& sources, const std::string& cache, const Beginning& beginning);

    // Who brings what is arriving; null where nothing is.
    RemoteModels* remote() const { return remote_.get(); }

    const std::deque<splat::Model>& all() const { return models_; }
    const std::vector<PlacedModel>& placed() const { return placed_; }
    bool has_colour() const;
    bool are_complete() const;

  private:
    const splat::Model& open(const std::string& file, const std::string& cache, const Beginning& beginning);

    std::unique_ptr<RemoteModels> remote_;
    std::deque<splat::Model> models_;
    std::vector<PlacedModel> placed_;
};

}  // namespace scene
