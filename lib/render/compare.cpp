#include "render/compare.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.h"
#include "core/parallel.h"

namespace render {
namespace {

constexpr int kRegion = 16;  // side of the regions among which the worst is looked for
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Two pictures of one size, and which pixels each covers (1 or 0).
struct Pair {
    int width, height;
    const uint8_t *a, *b;  // rgb
    std::vector<uint8_t> covered_a, covered_b;

    size_t pixel_count() const { return static_cast<size_t>(width) * static_cast<size_t>(height); }
};

// Calls test(i) for the pixels i of the 3x3 about `pixel` that the picture has; whether all hold.
template <class Test>
bool all_about(size_t pixel, int width, int height, const Test& test) {
    const int x = static_cast<int>(pixel % static_cast<size_t>(width));
    const int y = static_cast<int>(pixel / static_cast<size_t>(width));
    for (int v = std::max(y - 1, 0); v < std::min(y + 2, height); ++v)
        for (int u = std::max(x - 1, 0); u < std::min(x + 2, width); ++u)
            if (!test(static_cast<size_t>(v) * static_cast<size_t>(width) + static_cast<size_t>(u)))
                return false;
    return true;
}

double psnr(uint64_t squared_error, uint64_t values) {
    if (squared_error == 0) return kInfinity;
    return 10 * std::log10(255.0 * 255.0 * static_cast<double>(values) / static_cast<double>(squared_error));
}

// Sums are integers, so that no order of adding changes them.
struct Sums {
    uint64_t squared = 0, squared_inside = 0;
    uint64_t inside = 0, only_a = 0, only_b = 0, holes_inside = 0;
    uint64_t worst = 0;
    int max = 0, worst_x = 0, worst_y = 0;
};

// Adds the pixels of a row from x_begin to x_end; returns their squared error.
uint64_t add_run(const Pair& p, size_t begin, size_t end, Sums& sums) {
    uint64_t run = 0;
    for (size_t i = begin; i < end; ++i) {
        int squared = 0;
        for (size_t c = 3 * i; c < 3 * i + 3; ++c) {
            const int difference = std::abs(p.a[c] - p.b[c]);
            squared += difference * difference;
            sums.max = std::max(sums.max, difference);
        }
        const bool in_a = p.covered_a[i] != 0, in_b = p.covered_b[i] != 0;
        run += static_cast<uint64_t>(squared);
        sums.squared_inside += in_a && in_b ? static_cast<uint64_t>(squared) : 0;
        sums.inside += in_a && in_b;
        sums.only_a += in_a && !in_b;
        if (in_b && !in_a) {
            ++sums.only_b;
            sums.holes_inside +=
                all_about(i, p.width, p.height, [&](size_t near) { return p.covered_b[near] != 0; });
        }
    }
    sums.squared += run;
    return run;
}

// One row of regions, from row y_begin on.
Sums sum_band(const Pair& p, int y_begin) {
    const int y_end = std::min(y_begin + kRegion, p.height);
    std::vector<uint64_t> regions(static_cast<size_t>((p.width + kRegion - 1) / kRegion), 0);
    Sums sums;
    for (int y = y_begin; y < y_end; ++y) {
        const size_t row = static_cast<size_t>(y) * static_cast<size_t>(p.width);
        for (size_t r = 0; r < regions.size(); ++r) {
            const size_t x = r * kRegion;
            const size_t x_end = std::min(x + kRegion, static_cast<size_t>(p.width));
            regions[r] += add_run(p, row + x, row + x_end, sums);
        }
    }
    const auto worst = std::max_element(regions.begin(), regions.end());
    sums.worst = *worst;
    sums.worst_x = static_cast<int>(worst - regions.begin()) * kRegion;
    sums.worst_y = y_begin;
    return sums;
}

Sums sum_picture(const Pair& p) {
    std::vector<Sums> bands(static_cast<size_t>((p.height + kRegion - 1) / kRegion));
    core::parallel_for(bands.size(),
                       [&](size_t i) { bands[i] = sum_band(p, static_cast<int>(i) * kRegion); });
    Sums total = bands[0];
    for (size_t i = 1; i < bands.size(); ++i) {
        const Sums& band = bands[i];
        total.squared += band.squared, total.squared_inside += band.squared_inside;
        total.inside += band.inside, total.only_a += band.only_a, total.only_b += band.only_b;
        total.holes_inside += band.holes_inside;
        total.max = std::max(total.max, band.max);
        if (band.worst > total.worst)
            total.worst = band.worst, total.worst_x = band.worst_x, total.worst_y = band.worst_y;
    }
    return total;
}

// Luma less 128: variances do not notice, and single precision keeps twice as much of them.
constexpr float kLumaShift = 128;

void luma_row(const uint8_t* rgb, size_t width, float* out) {
    for (size_t x = 0; x < width; ++x)
        out[x] = 0.299f * rgb[3 * x] + 0.587f * rgb[3 * x + 1] + 0.114f * rgb[3 * x + 2] - kLumaShift;
}

std::vector<float> gaussian_window(int size) {
    std::vector<float> weights(static_cast<size_t>(std::min(size, 11)));
    const double middle = (static_cast<double>(weights.size()) - 1) / 2;
    double sum = 0;
    for (size_t i = 0; i < weights.size(); ++i) {
        const double d = (static_cast<double>(i) - middle) / 1.5;
        weights[i] = static_cast<float>(std::exp(-0.5 * d * d));
        sum += static_cast<double>(weights[i]);
    }
    for (float& w : weights) w = static_cast<float>(static_cast<double>(w) / sum);
    return weights;
}

// The local moments that SSIM needs, one row of windows each.
enum Moment { kMeanA, kMeanB, kSquares, kProducts, kMomentCount };

using Row = std::vector<float>;

// One row of the picture, filtered along x: the means of a, b, a^2 + b^2 and ab under the window.
class RowFilter {
  public:
    RowFilter(const Pair& pair, const std::vector<float>& window)
        : pair_(pair), window_(window), raw_(kMomentCount, Row(static_cast<size_t>(pair.width))) {}

    void filter(int y, Row* out) {
        const size_t width = static_cast<size_t>(pair_.width);
        const size_t offset = 3 * static_cast<size_t>(y) * width;
        luma_row(pair_.a + offset, width, raw_[kMeanA].data());
        luma_row(pair_.b + offset, width, raw_[kMeanB].data());
        for (size_t x = 0; x < width; ++x) {
            const float a = raw_[kMeanA][x], b = raw_[kMeanB][x];
            raw_[kSquares][x] = a * a + b * b;
            raw_[kProducts][x] = a * b;
        }
        for (int m = 0; m < kMomentCount; ++m) convolve(raw_[static_cast<size_t>(m)], out[m]);
    }

  private:
    void convolve(const Row& in, Row& out) const {
        const size_t count = out.size();
        std::fill(out.begin(), out.end(), 0.0f);
        for (size_t k = 0; k < window_.size(); ++k) {
            const float weight = window_[k];
            const float* from = in.data() + k;
            float* to = out.data();
            for (size_t x = 0; x < count; ++x) to[x] += weight * from[x];
        }
    }

    const Pair& pair_;
    const std::vector<float>& window_;
    std::vector<Row> raw_;
};

// The sum of SSIM over one row of windows, from its moments.
double ssim_row(const Row* moments) {
    constexpr float kC1 = 0.01f * 0.01f * 255 * 255, kC2 = 0.03f * 0.03f * 255 * 255;
    double sum = 0;
    for (size_t x = 0; x < moments[0].size(); ++x) {
        const float shifted_a = moments[kMeanA][x], shifted_b = moments[kMeanB][x];
        const float variances =
            moments[kSquares][x] - (shifted_a * shifted_a + shifted_b * shifted_b);  // of a plus of b
        const float covariance = moments[kProducts][x] - shifted_a * shifted_b;
        const float a = shifted_a + kLumaShift, b = shifted_b + kLumaShift;
        const float similarity =
            ((2 * a * b + kC1) * (2 * covariance + kC2)) / ((a * a + b * b + kC1) * (variances + kC2));
        sum += static_cast<double>(similarity);
    }
    return sum;
}

// Windows whose top rows are [begin, end): a ring of filtered rows slides down the picture.
double ssim_band(const Pair& p, const std::vector<float>& window_x, const std::vector<float>& window_y,
                 size_t begin, size_t end) {
    const size_t columns = static_cast<size_t>(p.width) - window_x.size() + 1;
    const size_t height = window_y.size();
    RowFilter filter(p, window_x);
    std::vector<Row> ring(height * kMomentCount, Row(columns));
    Row moments[kMomentCount];
    double sum = 0;
    for (size_t y = begin; y < end + height - 1; ++y) {
        filter.filter(static_cast<int>(y), &ring[y % height * kMomentCount]);
        if (y < begin + height - 1) continue;
        for (size_t m = 0; m < kMomentCount; ++m) {
            moments[m].assign(columns, 0.0f);
            for (size_t k = 0; k < height; ++k) {
                const float weight = window_y[k];
                const float* from = ring[(y + 1 + k) % height * kMomentCount + m].data();
                float* to = moments[m].data();
                for (size_t x = 0; x < columns; ++x) to[x] += weight * from[x];
            }
        }
        sum += ssim_row(moments);
    }
    return sum;
}

double mean_ssim(const Pair& p) {
    const std::vector<float> window_x = gaussian_window(p.width), window_y = gaussian_window(p.height);
    const size_t columns = static_cast<size_t>(p.width) - window_x.size() + 1;
    const size_t rows = static_cast<size_t>(p.height) - window_y.size() + 1;
    constexpr size_t kBandRows = 64;  // the window's own rows, filtered twice, cost a sixth
    std::vector<double> sums((rows + kBandRows - 1) / kBandRows);
    core::parallel_pieces(rows, kBandRows, [&](size_t begin, size_t end) {
        sums[begin / kBandRows] = ssim_band(p, window_x, window_y, begin, end);
    });
    double sum = 0;
    for (double s : sums) sum += s;
    return sum / (static_cast<double>(columns) * static_cast<double>(rows));
}

ImageDifference measure(const Pair& p) {
    const Sums sums = sum_picture(p);
    ImageDifference d;
    d.psnr_db = psnr(sums.squared, 3 * p.pixel_count());
    d.psnr_inside_db = psnr(sums.squared_inside, 3 * sums.inside);
    d.ssim = sums.squared == 0 ? 1 : mean_ssim(p);
    const uint64_t in_either = sums.inside + sums.only_a + sums.only_b, in_b = sums.inside + sums.only_b;
    if (in_either > 0) d.coverage_iou = static_cast<double>(sums.inside) / static_cast<double>(in_either);
    if (sums.only_a > 0)
        d.silhouette_growth =
            in_b > 0 ? static_cast<double>(sums.only_a) / static_cast<double>(in_b) : kInfinity;
    d.holes = sums.only_b, d.holes_inside = sums.holes_inside;
    d.max_difference = sums.max;
    d.worst_x = sums.worst_x, d.worst_y = sums.worst_y;
    const auto region_width = static_cast<uint64_t>(std::min(kRegion, p.width - d.worst_x));
    const auto region_height = static_cast<uint64_t>(std::min(kRegion, p.height - d.worst_y));
    d.worst_psnr_db = psnr(sums.worst, 3 * region_width * region_height);
    return d;
}

template <class Picture>
void check_sizes(const Picture& a, const Picture& b) {
    if (a.width != b.width || a.height != b.height)
        throw core::Error(core::text("the first picture is %d x %d pixels, the second %d x %d", a.width,
                                     a.height, b.width, b.height));
    if (a.width < 1 || a.height < 1) throw core::Error("a picture without pixels cannot be compared");
}

std::vector<uint8_t> coverage(const Image& image, glm::u8vec3 background) {
    std::vector<uint8_t> covered(static_cast<size_t>(image.width) * static_cast<size_t>(image.height));
    for (size_t i = 0; i < covered.size(); ++i) {
        const uint8_t* p = image.rgb.data() + 3 * i;
        covered[i] = p[0] != background.r || p[1] != background.g || p[2] != background.b;
    }
    return covered;
}

std::vector<uint8_t> coverage(const Frame& frame) {
    std::vector<uint8_t> covered(frame.depth.size());
    for (size_t i = 0; i < covered.size(); ++i) covered[i] = std::isfinite(frame.depth[i]);
    return covered;
}

std::vector<uint8_t> over_black(const Frame& frame) {
    std::vector<uint8_t> rgb = frame.rgb;
    for (size_t i = 0; i < frame.alpha.size(); ++i)
        for (size_t c = 3 * i; c < 3 * i + 3; ++c)
            rgb[c] = static_cast<uint8_t>((frame.alpha[i] * rgb[c] + 127) / 255);
    return rgb;
}

std::optional<double> depth_rmse_px(const Frame& a, const Frame& reference, double focal_px) {
    double sum = 0;
    uint64_t count = 0;
    for (size_t i = 0; i < a.depth.size(); ++i) {
        const double za = static_cast<double>(a.depth[i]), zb = static_cast<double>(reference.depth[i]);
        if (!std::isfinite(za) || !std::isfinite(zb)) continue;
        const double error = (za / zb - 1) * focal_px;
        sum += error * error;
        ++count;
    }
    if (count == 0) return std::nullopt;
    return std::sqrt(sum / static_cast<double>(count));
}

uint64_t count_show_through(const Frame& a, const Frame& reference, double focal_px) {
    uint64_t count = 0;
    for (size_t i = 0; i < a.depth.size(); ++i) {
        // Not where `a` is a hole, and of neighbours that the reference does not cover none is nearer.
        const double za = static_cast<double>(a.depth[i]);
        count += std::isfinite(za) && all_about(i, a.width, a.height, [&](size_t near) {
                     return (za / static_cast<double>(reference.depth[near]) - 1) * focal_px > kShowThroughPx;
                 });
    }
    return count;
}

}  // namespace

ImageDifference compare(const Image& a, const Image& b, glm::u8vec3 background) {
    check_sizes(a, b);
    return measure(
        {a.width, a.height, a.rgb.data(), b.rgb.data(), coverage(a, background), coverage(b, background)});
}

ImageDifference compare(const Frame& a, const Frame& reference, double focal_px) {
    check_sizes(a, reference);
    const std::vector<uint8_t> rgb_a = over_black(a), rgb_b = over_black(reference);
    ImageDifference d =
        measure({a.width, a.height, rgb_a.data(), rgb_b.data(), coverage(a), coverage(reference)});
    d.depth_rmse_px = depth_rmse_px(a, reference, focal_px);
    d.show_through = count_show_through(a, reference, focal_px);
    return d;
}

Image difference_picture(const Image& a, const Image& b, glm::u8vec3 background) {
    check_sizes(a, b);
    const std::vector<uint8_t> in_a = coverage(a, background), in_b = coverage(b, background);
    Image out{a.width, a.height, std::vector<uint8_t>(a.rgb.size())};
    for (size_t i = 0; i < in_a.size(); ++i) {
        uint8_t* to = out.rgb.data() + 3 * i;
        if (in_a[i] != in_b[i]) {
            to[in_a[i] ? 0 : 2] = 255;
            continue;
        }
        for (size_t c = 0; c < 3; ++c)
            to[c] = static_cast<uint8_t>(std::min(8 * std::abs(a.rgb[3 * i + c] - b.rgb[3 * i + c]), 255));
    }
    return out;
}

}  // namespace render
