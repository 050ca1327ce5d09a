// PNG out by libdeflate, PNG in by libpng.
#include <libdeflate.h>
#include <png.h>

#include <csetjmp>
#include <cstring>
#include <new>

#include "core/error.h"
#include "render/image.h"
#include "render/png_reader.h"

namespace render {
namespace {

using core::Error;
using core::text;

constexpr unsigned char kSignature[8] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};

struct CompressorDeleter {
    void operator()(libdeflate_compressor* c) const { libdeflate_free_compressor(c); }
};

// Kept by each encoding thread: a compressor and two picture-sized buffers cost more to make than to use.
struct Scratch {
    std::unique_ptr<libdeflate_compressor, CompressorDeleter> compressor{libdeflate_alloc_compressor(1)};
    std::vector<uint8_t> filtered, compressed;
};

// Every row gets the Up filter: each byte less the one above it.
void filter_up(const uint8_t* pixels, size_t row_bytes, size_t height, uint8_t* out) {
    constexpr uint8_t kUp = 2;
    *out++ = kUp;
    std::memcpy(out, pixels, row_bytes);
    for (size_t row = 1; row < height; ++row) {
        out += row_bytes;
        const uint8_t* above = pixels;
        pixels += row_bytes;
        *out++ = kUp;
        for (size_t i = 0; i < row_bytes; ++i) out[i] = static_cast<uint8_t>(pixels[i] - above[i]);
    }
}

void put_big_endian(std::vector<std::byte>& out, uint32_t value) {
    for (int shift = 24; shift >= 0; shift -= 8) out.push_back(std::byte(value >> shift));
}

void put_chunk(std::vector<std::byte>& out, const char* type, const void* data, size_t size) {
    put_big_endian(out, static_cast<uint32_t>(size));
    const size_t begin = out.size();
    const auto* letters = reinterpret_cast<const std::byte*>(type);
    const auto* bytes = static_cast<const std::byte*>(data);
    out.insert(out.end(), letters, letters + 4);
    out.insert(out.end(), bytes, bytes + size);
    put_big_endian(out, libdeflate_crc32(0, out.data() + begin, out.size() - begin));
}

}  // namespace

std::vector<std::byte> encode_png(const uint8_t* pixels, int width, int height, int channels) {
    check_image_size(width, height, "png");
    thread_local Scratch scratch;
    if (!scratch.compressor) throw std::bad_alloc();
    const size_t row_bytes = static_cast<size_t>(channels) * static_cast<size_t>(width);
    const size_t rows = static_cast<size_t>(height);
    scratch.filtered.resize((row_bytes + 1) * rows);
    filter_up(pixels, row_bytes, rows, scratch.filtered.data());
    scratch.compressed.resize(
        libdeflate_zlib_compress_bound(scratch.compressor.get(), scratch.filtered.size()));
    const size_t size =
        libdeflate_zlib_compress(scratch.compressor.get(), scratch.filtered.data(), scratch.filtered.size(),
                                 scratch.compressed.data(), scratch.compressed.size());

    std::vector<std::byte> header;
    put_big_endian(header, static_cast<uint32_t>(width));
    put_big_endian(header, static_cast<uint32_t>(height));
    const int colour_type = channels == 4 ? 6 : 2;
    for (int value : {8, colour_type, 0, 0, 0}) header.push_back(std::byte(value));  // 8 bits, not interlaced

    std::vector<std::byte> out;
    out.reserve(size + 64);
    for (unsigned char c : kSignature) out.push_back(std::byte(c));
    put_chunk(out, "IHDR", header.data(), header.size());
    put_chunk(out, "IDAT", scratch.compressed.data(), size);
    put_chunk(out, "IEND", nullptr, 0);
    return out;
}

bool is_png(std::span<const std::byte> bytes) {
    return bytes.size() >= sizeof kSignature && std::memcmp(bytes.data(), kSignature, sizeof kSignature) == 0;
}

namespace {

// libpng reports errors by longjmp().  All that a jump may skip is plain data; what owns memory lives in
// read_png(), outside the functions that are jumped out of.
struct PngReader {
    std::span<const std::byte> bytes;
    size_t at = 0;
    png_structp png = nullptr;
    png_infop info = nullptr;
    char message[128] = "";

    PngReader() = default;
    PngReader(const PngReader&) = delete;
    PngReader& operator=(const PngReader&) = delete;
    ~PngReader() { png_destroy_read_struct(&png, &info, nullptr); }
};

[[noreturn]] void on_error(png_structp png, png_const_charp message) {
    auto* reader = static_cast<PngReader*>(png_get_error_ptr(png));
    std::strncpy(reader->message, message, sizeof reader->message - 1);
    png_longjmp(png, 1);
}

void on_warning(png_structp, png_const_charp) {}

void on_read(png_structp png, png_bytep out, size_t size) {
    auto* reader = static_cast<PngReader*>(png_get_io_ptr(png));
    if (reader->bytes.size() - reader->at < size) png_error(png, "the file is cut off");
    std::memcpy(out, reader->bytes.data() + reader->at, size);
    reader->at += size;
}

// Reads the chunks before the picture; false on an error.
bool read_header(PngReader& reader) {
    if (setjmp(png_jmpbuf(reader.png))) return false;
    png_set_user_limits(reader.png, kMaxImageSide, kMaxImageSide);
    png_set_chunk_malloc_max(reader.png, 1 << 20);
    png_set_crc_action(reader.png, PNG_CRC_ERROR_QUIT, PNG_CRC_ERROR_QUIT);
    // Pictures are compared as the bytes they hold: nothing is converted between colour spaces.
    png_set_keep_unknown_chunks(reader.png, PNG_HANDLE_CHUNK_NEVER,
                                reinterpret_cast<png_const_bytep>("gAMA\0cHRM\0sRGB\0iCCP"), 4);
    png_set_read_fn(reader.png, &reader, on_read);
    png_read_info(reader.png, reader.info);
    return true;
}

// Any colour type to RGB over black.
void set_conversions(PngReader& reader) {
    png_set_expand(reader.png);
    png_set_scale_16(reader.png);
    png_set_gray_to_rgb(reader.png);
    png_color_16 black = {};
    png_set_background(reader.png, &black, PNG_BACKGROUND_GAMMA_SCREEN, 0, 1.0);
    png_set_interlace_handling(reader.png);
    png_read_update_info(reader.png, reader.info);
}

bool read_rows(PngReader& reader, size_t row_bytes, png_bytepp rows) {
    if (setjmp(png_jmpbuf(reader.png))) return false;
    set_conversions(reader);
    if (png_get_rowbytes(reader.png, reader.info) != row_bytes) png_error(reader.png, "not an RGB picture");
    png_read_image(reader.png, rows);
    png_read_end(reader.png, nullptr);
    return true;
}

// Deflate makes at most 1032 bytes of one, so that a small file cannot ask for much memory.
void check_claimed_size(const PngReader& reader, const std::string& name) {
    const uint64_t width = png_get_image_width(reader.png, reader.info);
    const uint64_t height = png_get_image_height(reader.png, reader.info);
    check_image_size(static_cast<int>(width), static_cast<int>(height), name);
    const uint64_t packed = height * png_get_rowbytes(reader.png, reader.info);
    if (packed / 1032 > reader.bytes.size())
        throw Error(text("%s: header claims %llu x %llu pixels, more than the file's %zu bytes can hold",
                         name.c_str(), static_cast<unsigned long long>(width),
                         static_cast<unsigned long long>(height), reader.bytes.size()));
}

}  // namespace

Image read_png(std::span<const std::byte> bytes, const std::string& name) {
    PngReader reader;
    reader.bytes = bytes;
    reader.png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &reader, on_error, on_warning);
    if (reader.png) reader.info = png_create_info_struct(reader.png);
    if (!reader.info) throw std::bad_alloc();
    if (!read_header(reader)) throw Error(text("%s: bad PNG: %s", name.c_str(), reader.message));
    check_claimed_size(reader, name);

    Image image;
    image.width = static_cast<int>(png_get_image_width(reader.png, reader.info));
    image.height = static_cast<int>(png_get_image_height(reader.png, reader.info));
    const size_t row_bytes = 3 * static_cast<size_t>(image.width);
    image.rgb.resize(row_bytes * static_cast<size_t>(image.height));
    std::vector<png_bytep> rows;
    for (size_t y = 0; y < static_cast<size_t>(image.height); ++y)
        rows.push_back(image.rgb.data() + y * row_bytes);
    if (!read_rows(reader, row_bytes, rows.data()))
        throw Error(text("%s: bad PNG: %s", name.c_str(), reader.message));
    return image;
}

}  // namespace render
