#include "render/image.h"

#include <gtest/gtest.h>
#include <hwy/targets.h>
#include <png.h>
#include <unistd.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <random>

#include "core/error.h"
#include "core/file.h"
#include "core/parallel.h"
#include "render/y4m.h"

namespace {

using render::Image;

constexpr int kSizes[][2] = {{1, 1},   {2, 1},  {1, 2},    {3, 5},  {16, 16},
                             {17, 33}, {64, 7}, {129, 65}, {255, 2}};

Image random_picture(int width, int height, unsigned seed) {
    std::mt19937 random(seed);
    Image image{width, height, std::vector<uint8_t>(size_t(3) * size_t(width) * size_t(height))};
    for (uint8_t& value : image.rgb) value = static_cast<uint8_t>(random());
    return image;
}

render::Frame random_frame(int width, int height, unsigned seed) {
    render::Frame frame;
    frame.resize(width, height);
    frame.rgb = random_picture(width, height, seed).rgb;
    for (size_t i = 0; i < frame.depth.size(); i += 2) frame.depth[i] = static_cast<float>(i) + 0.5f;
    return frame;
}

// A fresh folder for each test, removed at its end.
class Folder {
  public:
    Folder() {
        std::string pattern = (std::filesystem::temp_directory_path() / "qs-image-XXXXXX").string();
        if (!mkdtemp(pattern.data())) throw std::runtime_error("no temporary folder");
        path_ = pattern;
    }
    ~Folder() { std::filesystem::remove_all(path_); }
    std::string operator/(const std::string& name) const { return (path_ / name).string(); }
    size_t entry_count() const {
        return static_cast<size_t>(std::distance(std::filesystem::directory_iterator(path_), {}));
    }

  private:
    std::filesystem::path path_;
};

std::string slurp(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    EXPECT_TRUE(in.good()) << path;
    return {std::istreambuf_iterator<char>(in), {}};
}

std::vector<std::byte> bytes_of(const std::string& text) {
    const auto* begin = reinterpret_cast<const std::byte*>(text.data());
    return {begin, begin + text.size()};
}

// libpng's own reader and writer, as the judge.
std::vector<uint8_t> libpng_decode(const std::vector<std::byte>& bytes, int& width, int& height) {
    png_image png = {};
    png.version = PNG_IMAGE_VERSION;
    EXPECT_TRUE(png_image_begin_read_from_memory(&png, bytes.data(), bytes.size())) << png.message;
    png.format = PNG_FORMAT_RGB;
    std::vector<uint8_t> out(PNG_IMAGE_SIZE(png));
    EXPECT_TRUE(png_image_finish_read(&png, nullptr, out.data(), 0, nullptr)) << png.message;
    width = static_cast<int>(png.width), height = static_cast<int>(png.height);
    return out;
}

std::vector<std::byte> libpng_encode(const void* pixels, int width, int height, uint32_t format) {
    png_image png = {};
    png.version = PNG_IMAGE_VERSION;
    png.width = static_cast<uint32_t>(width), png.height = static_cast<uint32_t>(height);
    png.format = format;
    png_alloc_size_t size = 0;
    EXPECT_TRUE(png_image_write_get_memory_size(png, size, 0, pixels, 0, nullptr)) << png.message;
    std::vector<std::byte> out(size);
    EXPECT_TRUE(png_image_write_to_memory(&png, out.data(), &size, 0, pixels, 0, nullptr)) << png.message;
    out.resize(size);
    return out;
}

// What a throwing call said; fails the test where it did not throw.
template <class Kind = core::Error, class Call>
std::string message_of(const Call& call) {
    try {
        call();
    } catch (const Kind& error) {
        return error.what();
    }
    ADD_FAILURE() << "nothing was thrown";
    return "";
}

// ---- PNG, PPM, PFM

TEST(Png, LibpngReadsBackWhatWasEncoded) {
    for (const auto& [width, height] : kSizes) {
        const Image image = random_picture(width, height, 7);
        int w = 0, h = 0;
        EXPECT_EQ(libpng_decode(render::encode_png(image.rgb.data(), width, height), w, h), image.rgb);
        EXPECT_EQ(w, width);
        EXPECT_EQ(h, height);
    }
}

TEST(Png, IsSmallerForASmoothPicture) {
    Image image{640, 360, std::vector<uint8_t>(size_t(640) * 360 * 3)};
    for (size_t i = 0; i < image.rgb.size(); ++i) image.rgb[i] = static_cast<uint8_t>(i / (3 * 640));
    EXPECT_LT(render::encode_png(image.rgb.data(), 640, 360).size(), image.rgb.size() / 50);
}

TEST(ReadImage, TakesEveryColourTypeOfPng) {
    const uint8_t rgba[8] = {200, 100, 50, 255, 200, 100, 50, 128};
    const Image over_black = render::decode_image(libpng_encode(rgba, 2, 1, PNG_FORMAT_RGBA), "rgba.png");
    EXPECT_EQ(over_black.rgb, (std::vector<uint8_t>{200, 100, 50, 100, 50, 25}));

    const uint8_t grey[4] = {0, 1, 128, 255};
    EXPECT_EQ(render::decode_image(libpng_encode(grey, 2, 2, PNG_FORMAT_GRAY), "grey.png").rgb,
              (std::vector<uint8_t>{0, 0, 0, 1, 1, 1, 128, 128, 128, 255, 255, 255}));

    const uint16_t deep[3] = {0, 0, 65535};
    EXPECT_EQ(render::decode_image(libpng_encode(deep, 1, 1, PNG_FORMAT_LINEAR_RGB), "deep.png").rgb,
              (std::vector<uint8_t>{0, 0, 255}));
}

TEST(ReadImage, PpmRoundTripAndComments) {
    const Image image = random_picture(17, 5, 3);
    const Image back = render::decode_image(render::encode_ppm(image.rgb.data(), 17, 5), "a.ppm");
    EXPECT_EQ(back.width, 17);
    EXPECT_EQ(back.height, 5);
    EXPECT_EQ(back.rgb, image.rgb);
    const Image commented = render::decode_image(bytes_of("P6 # made\n#\n 1\t1\n255\nabc"), "b.ppm");
    EXPECT_EQ(commented.rgb, (std::vector<uint8_t>{'a', 'b', 'c'}));
}

TEST(ReadImage, RejectsAPngCutOffAtAnyByte) {
    const Image image = random_picture(5, 3, 1);
    const std::vector<std::byte> whole = render::encode_png(image.rgb.data(), 5, 3);
    EXPECT_EQ(render::decode_image(whole, "whole.png").rgb, image.rgb);
    for (size_t size = 0; size < whole.size(); ++size)
        EXPECT_THROW(render::decode_image({whole.data(), size}, "cut.png"), core::Error) << size;
}

TEST(ReadImage, RejectsAPngWithAnyBitFlipped) {
    const Image image = random_picture(5, 3, 2);
    const std::vector<std::byte> whole = render::encode_png(image.rgb.data(), 5, 3);
    for (size_t bit = 0; bit < whole.size() * 8; ++bit) {
        std::vector<std::byte> bad = whole;
        bad[bit / 8] ^= std::byte(1 << bit % 8);
        EXPECT_THROW(render::decode_image(bad, "flip.png"), core::Error) << bit;
    }
}

TEST(ReadImage, RejectsAPpmCutOffAtAnyByteOrWithBytesToSpare) {
    std::vector<std::byte> whole = render::encode_ppm(random_picture(3, 2, 1).rgb.data(), 3, 2);
    for (size_t size = 0; size < whole.size(); ++size)
        EXPECT_THROW(render::decode_image({whole.data(), size}, "cut.ppm"), core::Error) << size;
    whole.push_back(std::byte(0));
    EXPECT_EQ(message_of([&] { render::decode_image(whole, "long.ppm"); }),
              "long.ppm: 3 x 2 pixels need 18 bytes, the file has 19");
}

TEST(ReadImage, RejectsLyingPpmHeaders) {
    for (const char* header : {"P6\n-1 2\n255\nx", "P6\n0 2\n255\n", "P6\n65535 65535\n255\n",
                               "P6\n70000 1\n255\n", "P6\n99999999999 1\n255\n", "P6\n1 1\n65535\nabcdef",
                               "P6\n1 1\n255", "P6\nx", "P6#", "P5\n1 1\n255\na", "GIF89a", ""})
        EXPECT_THROW(render::decode_image(bytes_of(header), "bad.ppm"), core::Error) << header;
}

// The header of a PNG with sides of our choice and a correct checksum.
std::vector<std::byte> png_claiming(uint32_t width, uint32_t height) {
    std::vector<std::byte> png = render::encode_png(random_picture(1, 1, 1).rgb.data(), 1, 1);
    for (size_t i = 0; i < 4; ++i) {
        png[16 + i] = std::byte(width >> (24 - 8 * i));
        png[20 + i] = std::byte(height >> (24 - 8 * i));
    }
    uint32_t crc = ~0u;
    for (size_t i = 12; i < 29; ++i) {
        crc ^= static_cast<uint32_t>(png[i]);
        for (int k = 0; k < 8; ++k) crc = crc & 1 ? crc >> 1 ^ 0xedb88320u : crc >> 1;
    }
    for (size_t i = 0; i < 4; ++i) png[29 + i] = std::byte(~crc >> (24 - 8 * i));
    return png;
}

TEST(ReadImage, ChecksAClaimedPngSizeBeforeTakingMemory) {
    EXPECT_EQ(render::decode_image(png_claiming(1, 1), "one.png").width, 1);
    EXPECT_NE(message_of([] {
                  render::decode_image(png_claiming(16000, 16000), "big.png");
              }).find("header claims 16000 x 16000 pixels, more than the file's"),
              std::string::npos);
    EXPECT_NE(
        message_of([] { render::decode_image(png_claiming(60000, 60000), "huge.png"); }).find("at most"),
        std::string::npos);
    for (uint32_t side : {0u, 65536u, 0x7fffffffu, 0xffffffffu})
        EXPECT_THROW(render::decode_image(png_claiming(side, 1), "side.png"), core::Error) << side;
}

TEST(ReadImage, NamesTheFileThatIsMissing) {
    EXPECT_NE(message_of([] { render::read_image("/nonexistent/a.png"); }).find("/nonexistent/a.png: "),
              std::string::npos);
}

TEST(Pfm, IsLittleEndianAndBottomUp) {
    const float values[6] = {1, 2, 3, 4, 5, INFINITY};
    const std::vector<std::byte> pfm = render::encode_pfm(values, 3, 2);
    const std::string header = "Pf\n3 2\n-1.0\n";
    ASSERT_EQ(pfm.size(), header.size() + sizeof values);
    EXPECT_EQ(std::memcmp(pfm.data(), header.data(), header.size()), 0);
    float rows[6];
    std::memcpy(rows, pfm.data() + header.size(), sizeof rows);
    EXPECT_EQ(rows[0], 4);
    EXPECT_EQ(rows[2], INFINITY);
    EXPECT_EQ(rows[3], 1);
    EXPECT_EQ(rows[5], 3);
}

TEST(Encoders, RefuseSizesBeyondTheLimits) {
    const uint8_t pixel[3] = {};
    EXPECT_THROW(render::encode_png(pixel, 0, 1), core::Error);
    EXPECT_THROW(render::encode_png(pixel, 65536, 1), core::Error);
    EXPECT_THROW(render::encode_ppm(pixel, 65535, 65535), core::Error);
}

// ---- y4m

// BT.601, limited range, straight from the definition in integers of 1/256.
std::vector<uint8_t> yuv_oracle(const Image& image) {
    const int w = image.width, h = image.height;
    const auto at = [&](int x, int y, int c) {
        return int(
            image.rgb[3 * (size_t(std::min(y, h - 1)) * size_t(w) + size_t(std::min(x, w - 1))) + size_t(c)]);
    };
    std::vector<uint8_t> out;
    for (int y = 0; y < h; ++y)
        for (int x = 0; x < w; ++x)
            out.push_back(static_cast<uint8_t>(
                16 + (66 * at(x, y, 0) + 129 * at(x, y, 1) + 25 * at(x, y, 2) + 128) / 256));
    const int weights[2][3] = {{-19, -37, 56}, {56, -47, -9}};
    for (const auto& weight : weights)
        for (int y = 0; y < h; y += 2)
            for (int x = 0; x < w; x += 2) {
                int sum = 128 + 128 * 256;
                for (int c = 0; c < 3; ++c)
                    sum += weight[c] *
                           ((at(x, y, c) + at(x + 1, y, c) + at(x, y + 1, c) + at(x + 1, y + 1, c) + 1) / 2);
                out.push_back(static_cast<uint8_t>(sum / 256));
            }
    return out;
}

std::vector<uint8_t> convert(const Image& image) {
    std::vector<uint8_t> out(render::yuv420_size(image.width, image.height));
    render::rgb_to_yuv420(image.rgb.data(), image.width, image.height, out.data());
    return out;
}

TEST(Y4m, EveryProcessorTargetGivesTheOraclesBytes) {
    const int64_t supported = hwy::SupportedTargets();
    int tried = 0;
    for (int64_t rest = supported; rest != 0; rest &= rest - 1) {
        hwy::SetSupportedTargetsForTest(rest & -rest);
        ++tried;
        for (const auto& [width, height] : kSizes)
            for (unsigned seed = 0; seed < 4; ++seed) {
                const Image image = random_picture(width, height, seed);
                EXPECT_EQ(convert(image), yuv_oracle(image)) << hwy::TargetName(rest & -rest) << ' ' << width;
            }
    }
    hwy::SetSupportedTargetsForTest(0);
    EXPECT_GE(tried, 1);
}

TEST(Y4m, IsWithinItsStatedErrorOfTheExactColours) {
    for (int r = 0; r <= 255; r += 15)
        for (int g = 0; g <= 255; g += 15)
            for (int b = 0; b <= 255; b += 15) {
                const auto byte = [](int v) { return static_cast<uint8_t>(v); };
                const std::vector<uint8_t> yuv = convert({1, 1, {byte(r), byte(g), byte(b)}});
                const double y = 0.299 * r + 0.587 * g + 0.114 * b;
                EXPECT_NEAR(yuv[0], 16 + y * 219 / 255, 1);
                EXPECT_NEAR(yuv[1], 128 + (b - y) / 1.772 * 224 / 255, 1.5);
                EXPECT_NEAR(yuv[2], 128 + (r - y) / 1.402 * 224 / 255, 1.5);
            }
}

TEST(Y4m, GreyHasNoColour) {
    for (int v = 0; v < 256; ++v) {
        const std::vector<uint8_t> yuv = convert({2, 2, std::vector<uint8_t>(12, static_cast<uint8_t>(v))});
        EXPECT_EQ(yuv[4], 128);
        EXPECT_EQ(yuv[5], 128);
    }
}

TEST(Y4m, HeaderWritesRatesAsFractions) {
    EXPECT_EQ(render::y4m_header(1280, 720, 24),
              "YUV4MPEG2 W1280 H720 F24:1 Ip A1:1 C420jpeg XCOLORRANGE=LIMITED\n");
    EXPECT_NE(render::y4m_header(1, 1, 29.97).find(" F30000:1001 "), std::string::npos);
    EXPECT_NE(render::y4m_header(1, 1, 23.976).find(" F24000:1001 "), std::string::npos);
    EXPECT_NE(render::y4m_header(1, 1, 12.5).find(" F25:2 "), std::string::npos);
    EXPECT_NE(render::y4m_header(1, 1, 0.001).find(" F1:1000 "), std::string::npos);
    EXPECT_NE(render::y4m_header(1, 1, 1000).find(" F1000:1 "), std::string::npos);
}

// ---- names

TEST(FrameName, PutsTheNumberIn) {
    EXPECT_EQ(render::frame_name("f-%04d.png", 7), "f-0007.png");
    EXPECT_EQ(render::frame_name("f-%d.png", 12345), "f-12345.png");
    EXPECT_EQ(render::frame_name("f-%02d.png", 123), "f-123.png");
    EXPECT_EQ(render::frame_name("50%%/f.png", 7), "50%/f.png");
    EXPECT_EQ(render::frame_name("f.png", 7), "f.png");
    EXPECT_TRUE(render::has_frame_number("%d"));
    EXPECT_FALSE(render::has_frame_number("a%%d"));
}

TEST(FrameName, PutsTheEyeIn) {
    EXPECT_EQ(render::frame_name("%s/f-%03d.png", 7, "left"), "left/f-007.png");
    EXPECT_EQ(render::frame_name("f%%s-%d-%s", 1, "right"), "f%s-1-right");
    EXPECT_TRUE(render::has_eye("%s.png"));
    EXPECT_FALSE(render::has_eye("%%s.png"));
}

TEST(FrameName, RefusesWhatIsNotOneNumber) {
    for (const char* name : {"%s%s", "%", "%4d", "%04x", "%0d", "%010d", "%d%d", "%n", "%*d", "%ld", "a%%%"})
        EXPECT_THROW(render::frame_name(name, 1), core::UsageError) << name;
}

TEST(FormatOfName, GoesByTheExtension) {
    using render::ImageFormat;
    EXPECT_EQ(render::format_of_name("-"), ImageFormat::y4m);
    EXPECT_EQ(render::format_of_name("a.b/c-%04d.PNG"), ImageFormat::png);
    EXPECT_EQ(render::format_of_name("x.ppm"), ImageFormat::ppm);
    EXPECT_EQ(render::format_of_name("x.y4m"), ImageFormat::y4m);
    EXPECT_EQ(render::format_of_name("x.rgb"), ImageFormat::rgb);
    for (const char* name : {"x", "x.jpg", "x.png/y", "x."})
        EXPECT_THROW(render::format_of_name(name), core::UsageError) << name;
}

// ---- FrameWriter

class FrameWriterTest : public testing::Test {
  protected:
    ~FrameWriterTest() override { core::set_thread_count(0); }
    Folder folder;
};

// Frames whose encoding takes very different times, so that workers finish out of order.
constexpr int kFrames = 24;

std::string expected_stream(render::ImageFormat format) {
    std::string out = format == render::ImageFormat::y4m ? render::y4m_header(61, 43, 24) : "";
    for (int i = 0; i < kFrames; ++i) {
        const render::Frame frame = random_frame(61, 43, static_cast<unsigned>(i));
        if (format == render::ImageFormat::rgb) {
            out.append(frame.rgb.begin(), frame.rgb.end());
        } else if (format == render::ImageFormat::ppm) {
            for (std::byte b : render::encode_ppm(frame.rgb.data(), 61, 43)) out += static_cast<char>(b);
        } else {
            const std::vector<uint8_t> yuv = convert({61, 43, frame.rgb});
            out += "FRAME\n";
            out.append(yuv.begin(), yuv.end());
        }
    }
    return out;
}

TEST_F(FrameWriterTest, StreamsAreInOrderAndTheSameForAnyThreadCount) {
    using render::ImageFormat;
    for (const auto& [format, extension] :
         {std::pair{ImageFormat::y4m, "y4m"}, std::pair{ImageFormat::ppm, "ppm"},
          std::pair{ImageFormat::rgb, "rgb"}}) {
        const std::string expected = expected_stream(format);
        for (int threads : {1, 2, 16}) {
            core::set_thread_count(threads);
            const std::string path = folder / (std::string("out.") + extension);
            render::FrameWriter writer(path, format, 24);
            for (int i = 0; i < kFrames; ++i) writer.write(i, random_frame(61, 43, static_cast<unsigned>(i)));
            writer.finish();
            EXPECT_EQ(slurp(path), expected) << extension << ' ' << threads;
        }
    }
}

TEST_F(FrameWriterTest, WritesAFileForEachFrameAndItsDepth) {
    for (int threads : {1, 2, 16}) {
        core::set_thread_count(threads);
        render::FrameWriter writer(folder / "f-%03d.png", render::ImageFormat::png, 24);
        for (int i = 0; i < kFrames; ++i) {
            // Sizes may change between files.
            const render::Frame frame = random_frame(10 + i, 5, static_cast<unsigned>(i));
            writer.write(i, frame);
            writer.write_depth(folder / "z-%d.pfm", i, frame);
        }
        writer.finish();
        EXPECT_EQ(folder.entry_count(), size_t(2) * kFrames);
        for (int i = 0; i < kFrames; ++i) {
            const render::Frame frame = random_frame(10 + i, 5, static_cast<unsigned>(i));
            EXPECT_EQ(render::read_image(render::frame_name(folder / "f-%03d.png", i)).rgb, frame.rgb);
            const std::vector<std::byte> pfm = render::encode_pfm(frame.depth.data(), 10 + i, 5);
            EXPECT_EQ(bytes_of(slurp(render::frame_name(folder / "z-%d.pfm", i))), pfm);
        }
    }
}

TEST_F(FrameWriterTest, ANumberedY4mIsAStreamOfOneFrame) {
    render::FrameWriter writer(folder / "f-%d.y4m", render::ImageFormat::y4m, 24);
    for (int i = 0; i < 2; ++i) writer.write(i, random_frame(2, 2, 0));
    writer.finish();
    EXPECT_EQ(slurp(folder / "f-0.y4m"), slurp(folder / "f-1.y4m"));
    EXPECT_TRUE(slurp(folder / "f-1.y4m").starts_with("YUV4MPEG2 W2 H2 "));
}

TEST_F(FrameWriterTest, AFullDiskIsAnError) {
    render::FrameWriter writer("/dev/full", render::ImageFormat::rgb, 24);
    const std::string message = message_of([&] {
        for (int i = 0; i < 100; ++i) writer.write(i, random_frame(300, 200, 1));
        writer.finish();
    });
    EXPECT_NE(message.find("/dev/full"), std::string::npos) << message;
}

TEST_F(FrameWriterTest, AFailureStaysUntilTheEnd) {
    render::FrameWriter writer(folder / "absent/f-%d.png", render::ImageFormat::png, 24);
    EXPECT_THROW(
        {
            for (int i = 0; i < 100; ++i) writer.write(i, random_frame(4, 4, 1));
            writer.finish();
        },
        core::Error);
    EXPECT_THROW(writer.finish(), core::Error);
}

TEST_F(FrameWriterTest, LeavesNoStreamBehindUnlessFinished) {
    {
        render::FrameWriter writer(folder / "out.y4m", render::ImageFormat::y4m, 24);
        for (int i = 0; i < 3; ++i) writer.write(i, random_frame(16, 16, 1));
    }
    EXPECT_EQ(folder.entry_count(), 0u);
}

TEST_F(FrameWriterTest, RefusesASecondPictureForOnePngAndChangedSizes) {
    render::FrameWriter png(folder / "a.png", render::ImageFormat::png, 24);
    png.write(0, random_frame(4, 4, 1));
    EXPECT_THROW(png.write(1, random_frame(4, 4, 1)), core::Error);
    render::FrameWriter depth(folder / "a-%d.png", render::ImageFormat::png, 24);
    depth.write_depth(folder / "z.pfm", 0, random_frame(4, 4, 1));
    EXPECT_THROW(depth.write_depth(folder / "z.pfm", 1, random_frame(4, 4, 1)), core::Error);
    EXPECT_THROW(depth.write_depth(folder / "a-%d.png", 1, random_frame(4, 4, 1)), core::UsageError);
    render::FrameWriter stream(folder / "a.y4m", render::ImageFormat::y4m, 24);
    stream.write(0, random_frame(4, 4, 1));
    EXPECT_EQ(message_of([&] { stream.write(1, random_frame(4, 6, 1)); }),
              (folder / "a.y4m") + ": frame 1 is 4 x 6 pixels, the stream began with 4 x 4");
}

TEST_F(FrameWriterTest, RefusesRatesOutOfRange) {
    for (double rate : {0.0, -1.0, 1001.0, double(NAN), double(INFINITY)})
        EXPECT_THROW(render::FrameWriter(folder / "a.y4m", render::ImageFormat::y4m, rate), core::UsageError)
            << rate;
}

}  // namespace
