#include "scene/sources.h"

#include <algorithm>
#include <filesystem>
#include <map>

#include "core/error.h"
#include "core/file.h"
#include "scene/model_file.h"
#include "splat/level_prefix.h"

namespace scene {

namespace {

bool are_numbers(const std::string& text) {
    return !text.empty() && text.find_first_not_of("0123456789+-.,eE") == text.npos &&
           text.find_first_of("0123456789") != text.npos;
}

geom::Similarity read_similarity(const std::string& path) {
    const core::InputFile file(path);
    constexpr size_t kMostBytes = 65536;
    if (file.bytes().size() > kMostBytes)
        throw core::Error(file.name() + ": is longer than 65536 bytes; a transform is a few numbers");
    return geom::parse_similarity({reinterpret_cast<const char*>(file.bytes().data()), file.bytes().size()},
                                  file.name());
}

// A wrong transform looks like the end of a name; but then the file's name may be before it.
void refuse_slip(const std::string& word, const std::string& file, const std::string& transform) {
    std::error_code unknown;
    if (file != word && !std::filesystem::exists(word, unknown) && std::filesystem::exists(file, unknown))
        throw core::UsageError(
            word + ": '" + transform +
            "' is no transform (3, 4, 7 or 16 numbers with commas between, or a file's name "
            "that ends in .xf), and there is no file of the whole name");
}

Source parse_source(const std::string& word) {
    const size_t at = word.rfind('@');
    const std::string suffix = at == word.npos ? "" : word.substr(at + 1);
    const bool is_file = suffix.size() > 3 && suffix.ends_with(".xf");
    if (!is_file && !are_numbers(suffix)) {
        refuse_slip(word, word.substr(0, at), suffix);
        return {word, "", {}, false};
    }
    Source source{word.substr(0, at), is_file ? suffix : "", {}, true};
    if (is_file) {
        source.world_from_model = read_similarity(suffix);
        return source;
    }
    try {
        source.world_from_model = geom::parse_similarity(suffix, word);
    } catch (const core::Error& error) {
        throw core::UsageError(error.what());
    }
    return source;
}

}  // namespace

std::vector<Source> parse_sources(const std::vector<std::string>& words) {
    std::vector<Source> sources;
    for (const std::string& word : words) sources.push_back(parse_source(word));
    if (std::count_if(sources.begin(), sources.end(), [](const Source& s) { return s.file == "-"; }) > 1)
        throw core::UsageError("SOURCE: only one of them can be standard input");
    return sources;
}

Models::Models(const std::vector<Source>& sources, const std::string& cache, const Beginning& beginning) {
    std::map<std::string, const splat::Model*> by_name;
    for (const Source& source : sources) {
        const splat::Model*& model = by_name[source.file];
        if (!model) model = &open(source.file, cache, beginning);
        if (model->is_arriving()) remote_->place(source.file, placed_.size(), *model);
        placed_.push_back({model, source.world_from_model});
    }
}

const splat::Model& Models::open(const std::string& file, const std::string& cache,
                                 const Beginning& beginning) {
    if (!is_url(file)) return models_.emplace_back(open_model_file(file));
    if (!remote_) remote_ = std::make_unique<RemoteModels>(cache);
    const splat::Model& model = models_.emplace_back(remote_->open(file));
    if (beginning.needs_first_picture) remote_->bring_first_picture(file);
    remote_->bring_blocks(file, model, 1);
    if (beginning.needs_outline)
        for (bool is_known = false; !is_known;) {
            const splat::LevelPrefix outline = splat::level_prefix(model, kOutlineLevel);
            remote_->bring_blocks(file, model, outline.blocks);
            is_known = outline.is_known;
        }
    return model;
}

bool Models::has_colour() const {
    return std::any_of(models_.begin(), models_.end(), [](const splat::Model& model) {
        return model.header().flags & (splat::kHasColour | splat::kConstantColour);
    });
}

bool Models::are_complete() const {
    return std::all_of(models_.begin(), models_.end(), [](const splat::Model& m) { return m.is_complete(); });
}

}  // namespace scene
