// Two pictures, or two folders of frames, as qs-compare takes them: what belongs to what, limits, and
// reports.
#pragma once

#include <limits>
#include <span>
#include <string>
#include <vector>

#include "core/json.h"
#include "render/compare.h"

namespace render {

// What is compared with what.
struct PicturePair {
    std::string name;  // for reports: the file's name in both folders; of single pictures, the first's path
    std::string a, b;  // paths
};

struct PicturePairs {
    std::vector<PicturePair> pairs;
    std::vector<std::string> failures;  // a sentence for each folder that lacks frames of the other
};

// Of two folders, the PNG and PPM files (by extension, in either case) in the order of their names, paired by
// name; of anything else, the two as they are.  Throws core::UsageError where only one is a folder or both
// are "-"; core::Error where a folder has no frames.
PicturePairs pair_pictures(const std::string& a, const std::string& b);

struct NamedDifference {
    std::string name;
    ImageDifference difference;
};

// What a script tolerates; a value that is not finite asks for nothing.
struct DifferenceLimits {
    static constexpr double kNone = std::numeric_limits<double>::infinity();
    double min_psnr_db = -kNone, min_ssim = -kNone, min_iou = -kNone;
    double max_growth_percent = kNone, max_holes = kNone, max_difference = kNone;
};

// One sentence for each limit that a picture breaks, in the order above: "a.png: psnr 28.1 dB, below
// --min-psnr 30".
std::vector<std::string> broken_limits(const NamedDifference& picture, const DifferenceLimits& limits);

// The picture with the lowest PSNR, the first of equals.  `pictures` is not empty.
const NamedDifference& worst_picture(std::span<const NamedDifference> pictures);

// The members of ImageDifference under their names, depth_rmse_px and show_through where they are there; null
// for infinity.
core::Json to_json(const NamedDifference& picture);

// A table, one line a picture, and a last line that names the worst picture and its worst region.
std::string to_text(std::span<const NamedDifference> pictures);

}  // namespace render
