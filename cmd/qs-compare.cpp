// qs-compare: say how far pictures are from reference pictures.  The work is render::compare().
#include <array>
#include <atomic>
#include <cmath>
#include <filesystem>
#include <optional>
#include <unordered_set>

#include "core/error.h"
#include "core/file.h"
#include "core/parallel.h"
#include "core/program.h"
#include "render/compare_set.h"

namespace {

using core::text;

struct Options {
    std::string a, b, difference;
    std::array<double, 3> background{0, 0, 0};
    render::DifferenceLimits limits;
    bool json = false;
};

void add_options(core::Program& program, Options& o) {
    constexpr double kNone = render::DifferenceLimits::kNone;
    program.options.add_option("A", o.a, "Picture (PNG, PPM, - for standard input) or folder of frames")
        ->required();
    program.options.add_option("B", o.b, "What it is judged against, of the same kind")->required();
    program.options.add_flag("--json", o.json, "Print JSON, keys as in qs-compare(1)");
    program.options
        .add_option("--difference", o.difference,
                    "Write a picture of the difference: a PNG file, or a folder for folders")
        ->type_name("OUT");
    program.add_numbers("--background", o.background, "R,G,B",
                        "Colour of what is not covered, 0 to 255 each");
    program.add_number("--min-psnr", o.limits.min_psnr_db, 0, kNone, "decibels", "Fail below this PSNR");
    program.add_number("--min-ssim", o.limits.min_ssim, -1, 1, "", "Fail below this SSIM");
    program.add_number("--min-iou", o.limits.min_iou, 0, 1, "", "Fail below this overlap of the silhouettes");
    program.add_number("--max-growth", o.limits.max_growth_percent, 0, kNone, "percent",
                       "Fail where the silhouette grows by more");
    program.add_number("--max-holes", o.limits.max_holes, 0, kNone, "pixels", "Fail with more holes");
    program.add_number("--max-difference", o.limits.max_difference, 0, 255, "levels",
                       "Fail where a channel differs by more");
}

glm::u8vec3 background_of(const Options& o) {
    for (double value : o.background)
        if (value < 0 || value > 255 || value != std::floor(value))
            throw core::UsageError(text("--background: %g is not an integer from 0 to 255", value));
    return {o.background[0], o.background[1], o.background[2]};
}

// Where the difference pictures of the pairs go.
std::vector<std::string> difference_names(const Options& o, const std::vector<render::PicturePair>& pairs) {
    namespace fs = std::filesystem;
    if (o.difference.empty()) return {};
    std::error_code reason;
    if (!fs::is_directory(o.a, reason)) {
        if (!o.difference.ends_with(".png"))
            throw core::UsageError(
                text("--difference: '%s' is not a name that ends in .png", o.difference.c_str()));
        return {o.difference};
    }
    std::vector<std::string> names;
    names.reserve(pairs.size());
    for (const render::PicturePair& pair : pairs)
        names.push_back(
            (fs::path(o.difference) / (pair.name + (pair.name.ends_with(".png") ? "" : ".png"))).string());
    return names;
}

// Throws UsageError where a difference would be written over a picture or, in a folder, beside pictures that
// would be compared with it the next time.
void check_differences(const Options& o, const std::vector<std::string>& inputs,
                       const std::vector<std::string>& differences) {
    const auto refuse = [](const std::string& name) {
        throw core::UsageError(text("--difference: '%s' is one of the inputs", name.c_str()));
    };
    for (const std::string& input : {o.a, o.b})
        if (core::same_file(input, o.difference)) refuse(o.difference);
    std::unordered_set<std::string> files;
    for (const std::string& input : inputs)
        if (input != "-") files.insert(core::overwritten_file(input));
    for (const std::string& name : differences)
        if (files.contains(core::overwritten_file(name))) refuse(name);
}

void make_folder_of_differences(const Options& o) {
    std::error_code reason;
    if (o.difference.empty() || !std::filesystem::is_directory(o.a, reason)) return;
    std::filesystem::create_directories(o.difference, reason);
    if (reason)
        throw core::Error(
            text("%s: cannot make the folder: %s", o.difference.c_str(), reason.message().c_str()));
}

render::ImageDifference compare_pair(const render::PicturePair& pair, glm::u8vec3 background,
                                     const std::string& difference_name) {
    const render::Image a = render::read_image(pair.a), b = render::read_image(pair.b);
    if (a.width != b.width || a.height != b.height)
        throw core::Error(text("%s: %d x %d pixels, %s has %d x %d", pair.a.c_str(), a.width, a.height,
                               pair.b.c_str(), b.width, b.height));
    if (!difference_name.empty()) {
        const render::Image picture = render::difference_picture(a, b, background);
        core::OutputFile file(difference_name);
        file.write(render::encode_png(picture.rgb.data(), picture.width, picture.height));
        file.commit();
    }
    return render::compare(a, b, background);
}

struct Result {
    std::optional<render::ImageDifference> difference;
    std::string failure;  // where there is no difference
};

// All pairs, side by side.
std::vector<Result> compare_pairs(const std::vector<render::PicturePair>& pairs, glm::u8vec3 background,
                                  const std::vector<std::string>& difference_names) {
    std::vector<Result> results(pairs.size());
    core::Progress progress("comparing", pairs.size());
    std::atomic<uint64_t> done = 0;
    core::parallel_for(pairs.size(), [&](size_t i) {
        try {
            results[i].difference =
                compare_pair(pairs[i], background, difference_names.empty() ? "" : difference_names[i]);
        } catch (const core::Error& error) {
            results[i].failure = error.what();
        }
        progress.update(++done);
    });
    return results;
}

// A pair that fails is reported and left out.
std::vector<render::NamedDifference> compare_all(const std::vector<render::PicturePair>& pairs,
                                                 const std::vector<std::string>& differences,
                                                 glm::u8vec3 background) {
    const std::vector<Result> results = compare_pairs(pairs, background, differences);
    std::vector<render::NamedDifference> pictures;
    for (size_t i = 0; i < pairs.size(); ++i) {
        if (results[i].difference)
            pictures.push_back({pairs[i].name, *results[i].difference});
        else
            core::fail(results[i].failure);
    }
    return pictures;
}

core::Json summary(const std::vector<render::NamedDifference>& pictures,
                   const std::vector<std::string>& broken) {
    core::Json json;
    json["pictures"] = core::Json::array();
    for (const auto& picture : pictures) json["pictures"].push_back(to_json(picture));
    json["worst"] = render::worst_picture(pictures).name;
    json["broken_limits"] = broken;
    return json;
}

void run(const Options& o) {
    const glm::u8vec3 background = background_of(o);
    const auto [pairs, failures] = render::pair_pictures(o.a, o.b);
    const std::vector<std::string> differences = difference_names(o, pairs);
    std::vector<std::string> inputs;
    for (const render::PicturePair& pair : pairs) inputs.insert(inputs.end(), {pair.a, pair.b});
    check_differences(o, inputs, differences);
    core::Report report(inputs, differences);
    make_folder_of_differences(o);
    for (const std::string& failure : failures) core::fail(failure);
    const std::vector<render::NamedDifference> pictures = compare_all(pairs, differences, background);
    std::vector<std::string> broken;
    for (const auto& picture : pictures) {
        report.write(to_json(picture));
        const auto sentences = render::broken_limits(picture, o.limits);
        broken.insert(broken.end(), sentences.begin(), sentences.end());
    }
    report.commit();
    if (!pictures.empty() && !report.is_standard_output()) {
        if (o.json)
            core::print(summary(pictures, broken).dump(2) + "\n");
        else if (!core::is_quiet())
            core::print(render::to_text(pictures));
    }
    for (const std::string& sentence : broken) core::fail(sentence);
}

}  // namespace

int main(int argc, char** argv) {
    core::Program program("qs-compare", "Say how far pictures are from reference pictures.", QS_VERSION);
    Options options;
    add_options(program, options);
    return program.run(argc, argv, [&] { run(options); });
}
