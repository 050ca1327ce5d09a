#include "render/compare_set.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "core/error.h"

namespace render {
namespace {

namespace fs = std::filesystem;
using core::Error;
using core::text;
using core::UsageError;

bool is_folder(const std::string& path) {
    std::error_code ignored;  // what cannot be looked at is reported when it is opened
    return path != "-" && fs::is_directory(path, ignored);
}

bool is_picture_name(const std::string& name) {
    std::string extension = fs::path(name).extension().string();
    for (char& c : extension)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    return extension == ".png" || extension == ".ppm";
}

std::vector<std::string> picture_names(const std::string& folder) {
    std::vector<std::string> names;
    try {
        for (const auto& entry : fs::directory_iterator(folder)) {
            const std::string name = entry.path().filename().string();
            if (is_picture_name(name) && !entry.is_directory()) names.push_back(name);
        }
    } catch (const fs::filesystem_error& error) {
        throw Error(text("%s: cannot read the folder: %s", folder.c_str(), error.code().message().c_str()));
    }
    if (names.empty()) throw Error(text("%s: no PNG or PPM files in this folder", folder.c_str()));
    std::sort(names.begin(), names.end());
    return names;
}

// Every name should be among `present`, the names in `folder`.
void tell_of_missing(const std::vector<std::string>& names, const std::string& other,
                     const std::vector<std::string>& present, const std::string& folder,
                     std::vector<std::string>& failures) {
    std::vector<std::string> missing;
    std::set_difference(names.begin(), names.end(), present.begin(), present.end(),
                        std::back_inserter(missing));
    if (missing.empty()) return;
    failures.push_back(text("%s: %s is missing, which %s has (%zu of %zu frames missing)", folder.c_str(),
                            missing[0].c_str(), other.c_str(), missing.size(), names.size()));
}

core::Json number(double value) {
    return std::isfinite(value) ? core::Json(value) : core::Json(nullptr);
}

// A value for the table; equal pictures have "inf".
std::string cell(double value, int decimals) {
    return std::isfinite(value) ? text("%.*f", decimals, value) : "inf";
}

std::string worst_region(const ImageDifference& d) {
    if (d.max_difference == 0) return "-";
    return text("%d,%d psnr %.2f dB", d.worst_x, d.worst_y, d.worst_psnr_db);
}

}  // namespace

PicturePairs pair_pictures(const std::string& a, const std::string& b) {
    if (a == "-" && b == "-") throw UsageError("only one of the two pictures can be standard input");
    const bool folder_a = is_folder(a), folder_b = is_folder(b);
    if (folder_a != folder_b)
        throw UsageError(text("'%s' is a folder and '%s' is not; give two pictures or two folders of frames",
                              (folder_a ? a : b).c_str(), (folder_a ? b : a).c_str()));
    if (!folder_a) return {{{a, a, b}}, {}};
    const std::vector<std::string> names_a = picture_names(a), names_b = picture_names(b);
    PicturePairs found;
    tell_of_missing(names_a, a, names_b, b, found.failures);
    tell_of_missing(names_b, b, names_a, a, found.failures);
    for (const std::string& name : names_a)
        if (std::binary_search(names_b.begin(), names_b.end(), name))
            found.pairs.push_back({name, (fs::path(a) / name).string(), (fs::path(b) / name).string()});
    return found;
}

std::vector<std::string> broken_limits(const NamedDifference& picture, const DifferenceLimits& limits) {
    const ImageDifference& d = picture.difference;
    std::vector<std::string> sentences;
    const auto check = [&](bool broken, const char* what, double value, const char* unit, const char* side,
                           const char* option, double limit) {
        if (broken)
            sentences.push_back(text("%s: %s %.6g%s, %s %s %.6g", picture.name.c_str(), what, value, unit,
                                     side, option, limit));
    };
    const double growth_percent = 100 * d.silhouette_growth;
    const double holes = static_cast<double>(d.holes);
    check(d.psnr_db < limits.min_psnr_db, "psnr", d.psnr_db, " dB", "below", "--min-psnr",
          limits.min_psnr_db);
    check(d.ssim < limits.min_ssim, "ssim", d.ssim, "", "below", "--min-ssim", limits.min_ssim);
    check(d.coverage_iou < limits.min_iou, "coverage iou", d.coverage_iou, "", "below", "--min-iou",
          limits.min_iou);
    check(growth_percent > limits.max_growth_percent, "silhouette growth", growth_percent, " %", "above",
          "--max-growth", limits.max_growth_percent);
    check(holes > limits.max_holes, "holes", holes, "", "above", "--max-holes", limits.max_holes);
    check(d.max_difference > limits.max_difference, "largest difference", d.max_difference, " levels",
          "above", "--max-difference", limits.max_difference);
    return sentences;
}

const NamedDifference& worst_picture(std::span<const NamedDifference> pictures) {
    return *std::min_element(pictures.begin(), pictures.end(),
                             [](const NamedDifference& one, const NamedDifference& other) {
                                 return one.difference.psnr_db < other.difference.psnr_db;
                             });
}

core::Json to_json(const NamedDifference& picture) {
    const ImageDifference& d = picture.difference;
    core::Json json;
    json["name"] = picture.name;
    json["psnr_db"] = number(d.psnr_db);
    json["psnr_inside_db"] = number(d.psnr_inside_db);
    json["ssim"] = d.ssim;
    json["coverage_iou"] = d.coverage_iou;
    json["silhouette_growth"] = number(d.silhouette_growth);
    json["holes"] = d.holes;
    json["holes_inside"] = d.holes_inside;
    json["max_difference"] = d.max_difference;
    json["worst_x"] = d.worst_x;
    json["worst_y"] = d.worst_y;
    json["worst_psnr_db"] = number(d.worst_psnr_db);
    if (d.depth_rmse_px) json["depth_rmse_px"] = number(*d.depth_rmse_px);
    if (d.show_through) json["show_through"] = *d.show_through;
    return json;
}

std::string to_text(std::span<const NamedDifference> pictures) {
    size_t widest = 4;
    for (const NamedDifference& picture : pictures) widest = std::max(widest, picture.name.size());
    const int width = static_cast<int>(widest);
    std::string out =
        text("%-*s  %7s  %9s  %6s  %6s  %8s  %7s  %6s  %7s  %s\n", width, "name", "psnr_db", "inside_db",
             "ssim", "iou", "growth_%", "holes", "inside", "largest", "worst region");
    for (const auto& [name, d] : pictures)
        out +=
            text("%-*s  %7s  %9s  %6.4f  %6.4f  %8s  %7llu  %6llu  %7d  %s\n", width, name.c_str(),
                 cell(d.psnr_db, 2).c_str(), cell(d.psnr_inside_db, 2).c_str(), d.ssim, d.coverage_iou,
                 cell(100 * d.silhouette_growth, 3).c_str(), static_cast<unsigned long long>(d.holes),
                 static_cast<unsigned long long>(d.holes_inside), d.max_difference, worst_region(d).c_str());
    if (pictures.empty()) return out;
    const auto& [name, d] = worst_picture(pictures);
    if (d.max_difference == 0) return out + "all pixels are equal\n";
    return out + text("worst: %s, psnr %.2f dB; its worst region: 16 x 16 pixels at %s\n", name.c_str(),
                      d.psnr_db, worst_region(d).c_str());
}

}  // namespace render
