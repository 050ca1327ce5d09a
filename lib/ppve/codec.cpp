#include "ppve/codec.h"

// For the setting of literals below, which every libzstd of version 1.4 and later has.
#define ZSTD_STATIC_LINKING_ONLY
#include <zstd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <memory>

#include "core/bytes.h"
#include "core/error.h"
#include "core/parallel.h"
#include "ppve/byte_planes.h"
#include "ppve/lzw.h"
#include "ppve/residuals.h"

namespace ppve {

namespace {

// The layout: see ppve-protocol(5).
constexpr int kStripeRows =
    64;  // 13 stripes of 800 rows: work for many cores, and +0.5% of bytes against one
// zstd's level 1, which looks for matches less and less often where it finds none, and always codes by
// frequency: on residuals 1 to 2% smaller than plain level 1 and 30% faster.  Levels 3 and 9 are no smaller,
// and 5% smaller and four times as slow.  An acceleration of 32 instead of 128: 8% slower, and 3% larger to
// 2% smaller (ppve_bench, CT head).
constexpr int kLevel = 1, kAcceleration = 128;
constexpr size_t kPixelBytes = 7;

using Bytes = std::vector<std::byte>;

[[noreturn]] void fail(const char* what) {
    throw core::Error(std::string("depth image: ") + what);
}

struct FreeContext {
    void operator()(ZSTD_CCtx* context) const { ZSTD_freeCCtx(context); }
    void operator()(ZSTD_DCtx* context) const { ZSTD_freeDCtx(context); }
};

std::unique_ptr<ZSTD_CCtx, FreeContext> make_compressor() {
    std::unique_ptr<ZSTD_CCtx, FreeContext> context(ZSTD_createCCtx());
    const auto set = [&](ZSTD_cParameter parameter, int value) {
        const size_t done = ZSTD_CCtx_setParameter(context.get(), parameter, value);
        if (ZSTD_isError(done)) fail(ZSTD_getErrorName(done));
    };
    set(ZSTD_c_compressionLevel, kLevel);
    set(ZSTD_c_targetLength, kAcceleration);
    set(ZSTD_c_literalCompressionMode, ZSTD_lcm_huffman);
    return context;
}

ZSTD_CCtx* compressor() {
    thread_local const std::unique_ptr<ZSTD_CCtx, FreeContext> context = make_compressor();
    return context.get();
}

ZSTD_DCtx* decompressor() {
    thread_local const std::unique_ptr<ZSTD_DCtx, FreeContext> context(ZSTD_createDCtx());
    return context.get();
}

// A plane is its size in bytes (32 bits) and zstd's, or 0 and nothing where all of it is 0.
void put_empty_plane(Bytes& out) {
    out.resize(out.size() + sizeof(uint32_t));
}

void put_plane(std::span<const std::byte> plane, Bytes& out) {
    // Kept for the next plane: what grows a vector fills it first.
    thread_local Bytes coded;
    if (const size_t most = ZSTD_compressBound(plane.size()); coded.size() < most) coded.resize(most);
    const size_t size = ZSTD_compress2(compressor(), coded.data(), coded.size(), plane.data(), plane.size());
    if (ZSTD_isError(size)) fail(ZSTD_getErrorName(size));
    const auto stored = std::bit_cast<std::array<std::byte, sizeof(uint32_t)>>(uint32_t(size));
    out.insert(out.end(), stored.begin(), stored.end());
    out.insert(out.end(), coded.begin(), coded.begin() + std::ptrdiff_t(size));
}

// The bytes of one stripe, taken in turn.
class PlaneReader {
  public:
    explicit PlaneReader(std::span<const std::byte> bytes) : bytes_(bytes) {}

    // False: all of it is 0, and it is not written.
    bool take(std::span<std::byte> plane) {
        uint32_t size;
        if (bytes_.size() < sizeof(size)) fail("a stripe is cut off");
        std::memcpy(&size, bytes_.data(), sizeof(size));
        bytes_ = bytes_.subspan(sizeof(size));
        if (size > bytes_.size()) fail("a plane reaches beyond its stripe");
        if (size > 0) {
            const size_t got =
                ZSTD_decompressDCtx(decompressor(), plane.data(), plane.size(), bytes_.data(), size);
            if (ZSTD_isError(got) || got != plane.size()) fail("a plane is not what zstd makes of it");
        }
        bytes_ = bytes_.subspan(size);
        return size > 0;
    }
    void finish() const {
        if (!bytes_.empty()) fail("a stripe is too long");
    }

  private:
    std::span<const std::byte> bytes_;
};

// Bytes `first` to `last` of each number, a plane each.
void put_planes(std::span<const uint32_t> numbers, int first, int last, Bytes& plane, Bytes& out) {
    plane.resize(numbers.size());
    const uint32_t any = bits_of_any(numbers);
    for (int byte = first; byte <= last; ++byte) {
        if ((any >> 8 * byte & 0xff) == 0) {
            put_empty_plane(out);
            continue;
        }
        take_byte(numbers, byte, reinterpret_cast<uint8_t*>(plane.data()));
        put_plane(plane, out);
    }
}

void take_planes(PlaneReader& in, int first, int last, Bytes& plane, std::span<uint32_t> numbers) {
    plane.resize(numbers.size());
    std::fill(numbers.begin(), numbers.end(), 0u);
    for (int byte = first; byte <= last; ++byte) {
        if (!in.take(plane)) continue;
        const int shift = 8 * byte;
        for (size_t n = 0; n < numbers.size(); ++n) numbers[n] |= uint32_t(plane[n]) << shift;
    }
}

struct Rows {
    int first, count;
    size_t begin(int width) const { return size_t(first) * size_t(width); }
};

Rows rows_of(const DepthImage& image, size_t stripe) {
    const int first = int(stripe) * kStripeRows;
    return {first, std::min(kStripeRows, image.height() - first)};
}

size_t stripes_of(const DepthImage& image) {
    return (size_t(image.height()) + kStripeRows - 1) / kStripeRows;
}

// What a thread needs for a stripe, kept for the next one.
struct Workspace {
    Bytes plane;
    std::vector<uint32_t> numbers;
};

Bytes encode_stripe(const DepthImage& image, const Rows& rows) {
    thread_local Workspace work;
    const int width = image.width();
    const size_t begin = rows.begin(width);
    PixelMask mask(width, rows.count);
    for (int j = 0; j < rows.count; ++j) mask.set_row(j, &image.depth[begin + size_t(j) * size_t(width)]);
    const Stripe stripe{width, rows.count, &mask};
    Bytes out;
    if (mask.count() > 0)
        put_plane(std::as_bytes(std::span(mask.bits())), out);
    else
        put_empty_plane(out);
    depth_residuals(stripe, &image.depth[begin], work.numbers);
    put_planes(work.numbers, 0, 3, work.plane, out);
    colour_residuals(stripe, &image.colour[begin], work.numbers);
    put_planes(work.numbers, 0, 2, work.plane, out);
    if (image.normal.empty()) return out;
    std::vector<uint32_t> normals(size_t(width) * size_t(rows.count));
    std::copy_n(&image.normal[begin], normals.size(), normals.begin());
    colour_residuals(stripe, normals.data(), work.numbers);
    put_planes(work.numbers, 0, 1, work.plane, out);
    return out;
}

void decode_stripe(std::span<const std::byte> bytes, const Rows& rows, DepthImage& image) {
    thread_local Workspace work;
    const int width = image.width();
    const size_t begin = rows.begin(width);
    PlaneReader in(bytes);
    PixelMask mask(width, rows.count);
    in.take(std::as_writable_bytes(std::span(mask.bits())));
    if (!mask.is_clean(rows.count)) fail("pixels beyond a row's end");
    const Stripe stripe{width, rows.count, &mask};
    work.numbers.resize(mask.count());
    take_planes(in, 0, 3, work.plane, work.numbers);
    restore_depths(stripe, work.numbers, &image.depth[begin]);
    take_planes(in, 0, 2, work.plane, work.numbers);
    restore_colours(stripe, work.numbers, &image.colour[begin]);
    for (int j = 0; j < rows.count; ++j)
        mask.for_runs(
            j,
            [&](int first, int end) {
                const uint32_t* depth = &image.depth[begin + size_t(j) * size_t(width)];
                if (std::find(depth + first, depth + end, 0u) != depth + end)
                    fail("a pixel of the mask has no depth");
            },
            [](int, int) {});
    if (!image.normal.empty()) {
        take_planes(in, 0, 1, work.plane, work.numbers);
        std::vector<uint32_t> normals(size_t(width) * size_t(rows.count), 0);
        restore_colours(stripe, work.numbers, normals.data());
        for (size_t p = 0; p < normals.size(); ++p) image.normal[begin + p] = uint16_t(normals[p]);
    }
    in.finish();
}

// Sizes of the stripes (32 bits each), then the stripes.
Bytes encode_planes(const DepthImage& image) {
    std::vector<Bytes> stripes(stripes_of(image));
    core::parallel_for(stripes.size(),
                       [&](size_t s) { stripes[s] = encode_stripe(image, rows_of(image, s)); });
    core::ByteWriter out;
    for (const Bytes& s : stripes) out.put(uint32_t(s.size()));
    for (const Bytes& s : stripes) out.bytes.insert(out.bytes.end(), s.begin(), s.end());
    return std::move(out.bytes);
}

void decode_planes(std::span<const std::byte> bytes, DepthImage& image) {
    const size_t count = stripes_of(image);
    if (bytes.size() / sizeof(uint32_t) < count) fail("the table of stripes is cut off");
    std::vector<std::span<const std::byte>> stripes(count);
    size_t at = count * sizeof(uint32_t);
    for (size_t s = 0; s < count; ++s) {
        uint32_t size;
        std::memcpy(&size, bytes.data() + s * sizeof(size), sizeof(size));
        if (size > bytes.size() - at) fail("a stripe reaches beyond the end");
        stripes[s] = bytes.subspan(at, size);
        at += size;
    }
    if (at != bytes.size()) fail("bytes after the last stripe");
    core::parallel_for(count, [&](size_t s) { decode_stripe(stripes[s], rows_of(image, s), image); });
}

// The maps one after the other, as the paper's: 3 bytes of colour, 4 of depth, and 2 of normal where there
// are some.
Bytes maps_of(const DepthImage& image) {
    const size_t pixels = image.pixels();
    Bytes maps(pixels * (kPixelBytes + (image.normal.empty() ? 0 : 2)));
    for (size_t p = 0; p < pixels; ++p) std::memcpy(&maps[3 * p], &image.colour[p], 3);
    std::memcpy(&maps[3 * pixels], image.depth.data(), 4 * pixels);
    if (!image.normal.empty()) std::memcpy(&maps[kPixelBytes * pixels], image.normal.data(), 2 * pixels);
    return maps;
}

void decode_lzw(std::span<const std::byte> bytes, DepthImage& image) {
    const size_t pixels = image.pixels();
    Bytes maps(pixels * (kPixelBytes + (image.normal.empty() ? 0 : 2)));
    lzw_decode(bytes, maps);
    for (size_t p = 0; p < pixels; ++p) std::memcpy(&image.colour[p], &maps[3 * p], 3);
    std::memcpy(image.depth.data(), &maps[3 * pixels], 4 * pixels);
    if (!image.normal.empty()) std::memcpy(image.normal.data(), &maps[kPixelBytes * pixels], 2 * pixels);
    for (size_t p = 0; p < pixels; ++p)
        if (image.depth[p] == 0 && (image.colour[p] != 0 || (!image.normal.empty() && image.normal[p] != 0)))
            fail("a pixel without a surface has a colour");
}

}  // namespace

std::vector<std::byte> encode(const DepthImage& image, Codec codec) {
    return codec == Codec::lzw ? lzw_encode(maps_of(image)) : encode_planes(image);
}

void decode(std::span<const std::byte> bytes, Codec codec, bool has_normals, DepthImage& image) {
    image.clear(has_normals);
    if (codec == Codec::lzw)
        decode_lzw(bytes, image);
    else
        decode_planes(bytes, image);
}

}  // namespace ppve
