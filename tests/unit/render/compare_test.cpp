#include "render/compare.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/error.h"
#include "core/parallel.h"

namespace {

using render::compare;
using render::Image;
using render::ImageDifference;

constexpr glm::u8vec3 kBlack{0, 0, 0};

Image plain(int width, int height, uint8_t value) {
    return {width, height, std::vector<uint8_t>(size_t(3) * size_t(width) * size_t(height), value)};
}

void paint(Image& image, int x, int y, uint8_t r, uint8_t g, uint8_t b) {
    uint8_t* p = image.rgb.data() + 3 * (size_t(y) * size_t(image.width) + size_t(x));
    p[0] = r, p[1] = g, p[2] = b;
}

Image random_picture(int width, int height, unsigned seed) {
    std::mt19937 random(seed);
    Image image = plain(width, height, 0);
    for (uint8_t& value : image.rgb) value = static_cast<uint8_t>(random());
    return image;
}

TEST(Compare, EqualPicturesAreEqual) {
    const Image image = random_picture(40, 30, 1);
    const ImageDifference d = compare(image, image, kBlack);
    EXPECT_EQ(d.psnr_db, INFINITY);
    EXPECT_EQ(d.psnr_inside_db, INFINITY);
    EXPECT_EQ(d.worst_psnr_db, INFINITY);
    EXPECT_EQ(d.ssim, 1);
    EXPECT_EQ(d.coverage_iou, 1);
    EXPECT_EQ(d.silhouette_growth, 0);
    EXPECT_EQ(d.holes, 0u);
    EXPECT_EQ(d.max_difference, 0);
    EXPECT_FALSE(d.depth_rmse_px);
}

TEST(Compare, PsnrOfAConstantOffset) {
    const ImageDifference d = compare(plain(33, 17, 110), plain(33, 17, 100), kBlack);
    const double expected = 20 * std::log10(255.0 / 10);
    EXPECT_NEAR(d.psnr_db, expected, 1e-12);
    EXPECT_NEAR(d.psnr_inside_db, expected, 1e-12);
    EXPECT_NEAR(d.worst_psnr_db, expected, 1e-12);
    EXPECT_EQ(d.max_difference, 10);
}

TEST(Compare, PsnrCountsChannelsAlike) {
    Image a = plain(4, 1, 50), b = a;
    paint(a, 2, 0, 50, 50, 62);
    EXPECT_NEAR(compare(a, b, kBlack).psnr_db, 10 * std::log10(255.0 * 255 * 12 / 144), 1e-12);
}

TEST(Compare, InsideLeavesOutWhatOneOnlyCovers) {
    Image a = plain(10, 1, 0), b = a;
    for (int x = 0; x < 6; ++x) paint(a, x, 0, 100, 100, 100);
    for (int x = 2; x < 7; ++x) paint(b, x, 0, 100, 100, 103);
    const ImageDifference d = compare(a, b, kBlack);
    EXPECT_NEAR(d.psnr_inside_db, 10 * std::log10(255.0 * 255 * 3 / 9),
                1e-12);  // 4 shared pixels, one channel of 3
    EXPECT_DOUBLE_EQ(d.coverage_iou, 4.0 / 7);
    EXPECT_DOUBLE_EQ(d.silhouette_growth, 2.0 / 5);
    EXPECT_EQ(d.holes, 1u);
    EXPECT_EQ(d.max_difference, 103);
}

// A disc: of pixel (x, y) whether its centre is within it.
struct Disc {
    double x, y, radius;
    bool covers(int px, int py) const { return std::hypot(px - x, py - y) < radius; }
};

Image picture_of(const Disc& disc) {
    Image image = plain(60, 50, 0);
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x)
            if (disc.covers(x, y)) paint(image, x, y, 90, 90, 90);
    return image;
}

TEST(Compare, AHoleInsideTheSilhouetteIsCounted) {
    const Disc disc{30, 25, 18};
    const Image b = picture_of(disc);
    for (const Disc& hole : {Disc{30, 25, 0.5}, {25, 30, 0.5}, {30, 8.6, 0.5}, {33, 22, 4}}) {
        Image a = b;
        uint64_t punched = 0;
        for (int y = 0; y < a.height; ++y)
            for (int x = 0; x < a.width; ++x)
                if (hole.covers(x, y)) paint(a, x, y, 0, 0, 0), ++punched;
        ASSERT_GT(punched, 0u);
        EXPECT_EQ(compare(a, b, kBlack).holes_inside, punched) << hole.x << ' ' << hole.y;
        EXPECT_EQ(compare(a, b, kBlack).holes, punched);
    }
}

TEST(Compare, AnOutlineOffByAPixelIsNoHoleInside) {
    const Disc disc{30, 25, 18};
    const Image b = picture_of(disc);
    for (int y = -1; y <= 1; ++y)
        for (int x = -1; x <= 1; ++x) {
            const ImageDifference d = compare(picture_of({disc.x + x, disc.y + y, disc.radius}), b, kBlack);
            EXPECT_EQ(d.holes_inside, 0u) << x << ' ' << y;
            EXPECT_EQ(d.holes > 0, x != 0 || y != 0);
        }
    EXPECT_GT(compare(picture_of({disc.x + 3, disc.y, disc.radius}), b, kBlack).holes_inside, 0u);
}

TEST(Compare, BeyondThePicturesEdgeTheSilhouetteGoesOn) {
    const Image b = plain(7, 5, 90);
    for (const auto& [x, y] : {std::pair{0, 0}, {6, 4}, {0, 2}, {3, 4}}) {
        Image a = b;
        paint(a, x, y, 0, 0, 0);
        EXPECT_EQ(compare(a, b, kBlack).holes_inside, 1u) << x << ' ' << y;
    }
}

TEST(Compare, BackgroundDecidesWhatIsCovered) {
    Image a = plain(8, 8, 255), b = a;
    paint(b, 3, 3, 0, 0, 0);
    EXPECT_EQ(compare(a, b, glm::u8vec3{255, 255, 255}).holes, 1u);
    EXPECT_EQ(compare(a, b, kBlack).holes, 0u);
    EXPECT_EQ(compare(a, b, kBlack).silhouette_growth, 1.0 / 63);
}

TEST(Compare, EmptySilhouettes) {
    const Image empty = plain(4, 4, 0), full = plain(4, 4, 9);
    const ImageDifference both = compare(empty, empty, kBlack);
    EXPECT_EQ(both.coverage_iou, 1);
    EXPECT_EQ(both.silhouette_growth, 0);
    const ImageDifference only_a = compare(full, empty, kBlack);
    EXPECT_EQ(only_a.coverage_iou, 0);
    EXPECT_EQ(only_a.silhouette_growth, INFINITY);
    EXPECT_EQ(only_a.psnr_inside_db, INFINITY);
    const ImageDifference only_b = compare(empty, full, kBlack);
    EXPECT_EQ(only_b.holes, 16u);
    EXPECT_EQ(only_b.silhouette_growth, 0);
}

TEST(Compare, FindsTheWorstRegion) {
    const Image b = plain(70, 50, 80);
    Image a = b;
    paint(a, 5, 5, 200, 80, 80);    // one large error
    paint(a, 69, 49, 180, 80, 80);  // two that together are larger, in the small corner region 6 x 2
    paint(a, 64, 48, 180, 80, 80);
    const ImageDifference d = compare(a, b, kBlack);
    EXPECT_EQ(d.worst_x, 64);
    EXPECT_EQ(d.worst_y, 48);
    EXPECT_NEAR(d.worst_psnr_db, 10 * std::log10(255.0 * 255 * (3 * 6 * 2) / 20000), 1e-12);
    EXPECT_EQ(d.max_difference, 120);
}

// SSIM from its definition, window by window, in double precision.
double ssim_oracle(const Image& a, const Image& b) {
    const int side_x = std::min(a.width, 11), side_y = std::min(a.height, 11);
    const auto luma = [](const Image& image, int x, int y) {
        const uint8_t* p = image.rgb.data() + 3 * (size_t(y) * size_t(image.width) + size_t(x));
        return 0.299 * p[0] + 0.587 * p[1] + 0.114 * p[2];
    };
    double total = 0;
    int windows = 0;
    for (int y0 = 0; y0 + side_y <= a.height; ++y0)
        for (int x0 = 0; x0 + side_x <= a.width; ++x0) {
            double weight = 0, mean_a = 0, mean_b = 0, aa = 0, bb = 0, ab = 0;
            for (int y = 0; y < side_y; ++y)
                for (int x = 0; x < side_x; ++x) {
                    const double dx = x - (side_x - 1) / 2.0, dy = y - (side_y - 1) / 2.0;
                    const double w = std::exp(-(dx * dx + dy * dy) / (2 * 1.5 * 1.5));
                    const double va = luma(a, x0 + x, y0 + y), vb = luma(b, x0 + x, y0 + y);
                    weight += w, mean_a += w * va, mean_b += w * vb;
                    aa += w * va * va, bb += w * vb * vb, ab += w * va * vb;
                }
            mean_a /= weight, mean_b /= weight;
            const double var_a = aa / weight - mean_a * mean_a, var_b = bb / weight - mean_b * mean_b;
            const double covariance = ab / weight - mean_a * mean_b;
            const double c1 = 6.5025, c2 = 58.5225;
            total += (2 * mean_a * mean_b + c1) * (2 * covariance + c2) /
                     ((mean_a * mean_a + mean_b * mean_b + c1) * (var_a + var_b + c2));
            ++windows;
        }
    return total / windows;
}

TEST(Ssim, AgreesWithItsDefinition) {
    for (const auto& [width, height] : {std::pair{1, 1}, {5, 3}, {11, 11}, {12, 40}, {64, 9}, {50, 150}}) {
        const Image b = random_picture(width, height, 5);
        Image a = b;
        std::mt19937 random(6);
        for (uint8_t& value : a.rgb) value = static_cast<uint8_t>((value * 3 + random() % 256) / 4);
        EXPECT_NEAR(compare(a, b, kBlack).ssim, ssim_oracle(a, b), 2e-5) << width << 'x' << height;
        const Image other = random_picture(width, height, 7);
        EXPECT_NEAR(compare(other, b, kBlack).ssim, ssim_oracle(other, b), 2e-5) << width << 'x' << height;
    }
}

TEST(Ssim, OfFlatPicturesIsTheLuminanceTerm) {
    const double expected = (2.0 * 255 * 0 + 6.5025) / (255.0 * 255 + 6.5025);
    EXPECT_NEAR(compare(plain(20, 20, 255), plain(20, 20, 0), kBlack).ssim, expected, 1e-4);
}

TEST(Compare, IsTheSameForAnyThreadCount) {
    const Image a = random_picture(200, 301, 1), b = random_picture(200, 301, 2);
    core::set_thread_count(1);
    const ImageDifference one = compare(a, b, kBlack);
    core::set_thread_count(16);
    const ImageDifference many = compare(a, b, kBlack);
    core::set_thread_count(0);
    EXPECT_EQ(one.ssim, many.ssim);
    EXPECT_EQ(one.psnr_db, many.psnr_db);
    EXPECT_EQ(one.worst_x, many.worst_x);
    EXPECT_EQ(one.worst_y, many.worst_y);
}

TEST(Compare, RefusesSizesThatDiffer) {
    try {
        compare(plain(4, 3, 0), plain(4, 5, 0), kBlack);
        ADD_FAILURE() << "nothing was thrown";
    } catch (const core::Error& error) {
        EXPECT_STREQ(error.what(), "the first picture is 4 x 3 pixels, the second 4 x 5");
    }
    EXPECT_THROW(compare(plain(0, 0, 0), plain(0, 0, 0), kBlack), core::Error);
    EXPECT_THROW(render::difference_picture(plain(4, 3, 0), plain(3, 4, 0), kBlack), core::Error);
}

TEST(CompareFrames, CoverageIsFiniteDepthAndDepthErrorIsInPixels) {
    render::Frame a, b;
    a.resize(20, 10);
    b.resize(20, 10);
    b.depth[0] = 100, a.depth[0] = 101;  // 1 of 100 at 500 pixels: 5
    b.depth[1] = 10, a.depth[1] = 9.5;   // -25
    b.depth[2] = 10;                     // a hole
    a.depth[3] = 10, a.depth[4] = 10;    // growth
    b.rgb[0] = 20;                       // shared
    a.rgb[60] = 99;                      // where neither covers
    const ImageDifference d = compare(a, b, 500);
    EXPECT_EQ(d.holes, 1u);
    EXPECT_DOUBLE_EQ(d.silhouette_growth, 2.0 / 3);
    EXPECT_DOUBLE_EQ(d.coverage_iou, 2.0 / 5);
    EXPECT_NEAR(d.psnr_inside_db, 10 * std::log10(255.0 * 255 * 6 / 400), 1e-12);
    ASSERT_TRUE(d.depth_rmse_px);
    EXPECT_NEAR(*d.depth_rmse_px, std::sqrt((25.0 + 625.0) / 2), 1e-5);
    a.resize(20, 10);
    EXPECT_FALSE(compare(a, b, 500).depth_rmse_px);
}

// A disc in front of a wall that it stands out over, as depths: seen by 500 pixels, what is 1 behind 10 is 50
// behind.
render::Frame before_a_wall(const Disc& disc) {
    render::Frame frame;
    frame.resize(60, 50);
    for (int y = 0; y < frame.height; ++y)
        for (int x = 0; x < frame.width; ++x)
            if (y < 40)
                frame.depth[size_t(y) * size_t(frame.width) + size_t(x)] = disc.covers(x, y) ? 10.0f : 11.0f;
    return frame;
}

TEST(CompareFrames, WhatShowsThroughASurfaceIsCounted) {
    const render::Frame b = before_a_wall({30, 25, 12});
    EXPECT_EQ(compare(b, b, 500).show_through, 0u);
    render::Frame a = b;
    const size_t middle = 25 * 60 + 30;
    a.depth[middle] = 11, a.depth[middle + 5] = 11, a.depth[0] = 12;
    EXPECT_EQ(compare(a, b, 500).show_through, 3u);
    EXPECT_EQ(compare(a, b, 500).holes, 0u);
    a.depth[middle] = INFINITY;
    EXPECT_EQ(compare(a, b, 500).show_through, 2u);
    EXPECT_EQ(compare(a, b, 500).holes_inside, 1u);
}

TEST(CompareFrames, ErrorsOfDepthAndOutlinesDoNotShowThrough) {
    const render::Frame b = before_a_wall({30, 25, 12});
    render::Frame behind = b, before = b;
    for (float& depth : behind.depth) depth *= 1 + 15.9f / 500;
    for (float& depth : before.depth) depth *= 0.5f;
    EXPECT_EQ(compare(behind, b, 500).show_through, 0u);
    EXPECT_EQ(compare(before, b, 500).show_through, 0u);
    for (int y = -1; y <= 1; ++y)
        for (int x = -1; x <= 1; ++x)
            EXPECT_EQ(compare(before_a_wall({30.0 + x, 25.0 + y, 12}), b, 500).show_through, 0u)
                << x << ' ' << y;
    // Nor does it count where the wall ends, whatever is drawn behind its last row.
    render::Frame below = b;
    for (size_t i = 39 * 60; i < 40 * 60; ++i) below.depth[i] = 100;
    EXPECT_EQ(compare(below, b, 500).show_through, 0u);
    EXPECT_GT(compare(before_a_wall({30, 28, 12}), b, 500).show_through, 0u);
}

TEST(DifferencePicture, BrightensAndMarksSilhouettes) {
    Image a = plain(5, 1, 0), b = a;
    paint(a, 0, 0, 10, 20, 100), paint(b, 0, 0, 13, 19, 50);
    paint(a, 1, 0, 1, 1, 1);
    paint(b, 2, 0, 1, 1, 1);
    paint(a, 3, 0, 7, 7, 7), paint(b, 3, 0, 7, 7, 7);
    EXPECT_EQ(render::difference_picture(a, b, kBlack).rgb,
              (std::vector<uint8_t>{24, 8, 255, 255, 0, 0, 0, 0, 255, 0, 0, 0, 0, 0, 0}));
}

}  // namespace
