#include "ppve/messages.h"

#include <xxhash.h>

#include <algorithm>
#include <bit>
#include <type_traits>

#include "core/bytes.h"
#include "core/error.h"

namespace ppve {

namespace {

// The bytes: see ppve-protocol(5).
enum class Type : uint8_t {
    welcome = 1,
    request = 2,
    deletions = 3,
    answer = 4,
    refusal = 5,
    status_query = 6,
    status = 7
};

constexpr uint8_t kHasNear = 1, kHasFar = 2;
constexpr double kMostFootprint = 16, kMostBound = 1e6;

using Bytes = std::vector<std::byte>;

class Writer {
  public:
    explicit Writer(Type type) { put(type); }

    template <class T>
    void put(const T& value) {
        if constexpr (std::is_same_v<T, bool>)
            out_.put(uint8_t(value));
        else
            out_.put(value);
    }
    void put(const glm::dvec3& v) { put(v.x), put(v.y), put(v.z); }
    void put(std::span<const std::byte> bytes) {
        put(uint32_t(bytes.size()));
        out_.bytes.insert(out_.bytes.end(), bytes.begin(), bytes.end());
    }
    void put(const std::string& text, size_t most = kMostText) {
        put(std::as_bytes(std::span(text)).first(std::min(text.size(), most)));
    }
    void put(std::span<const uint64_t> numbers) {
        put(uint32_t(numbers.size()));
        for (const uint64_t n : numbers) put(n);
    }

    // The checksum is of all bytes before it.
    Bytes finish() && {
        const uint64_t sum = XXH3_64bits(out_.bytes.data(), out_.bytes.size());
        put(sum);
        return std::move(out_.bytes);
    }

  private:
    core::ByteWriter out_;
};

class Reader {
  public:
    Reader(std::span<const std::byte> bytes, const std::string& from) : from_(from) {
        constexpr size_t kSum = sizeof(uint64_t);
        if (bytes.size() <= kSum) fail("a message is cut off");
        bytes_ = bytes.first(bytes.size() - kSum);
        uint64_t sum;
        std::memcpy(&sum, bytes.data() + bytes_.size(), kSum);
        if (sum != XXH3_64bits(bytes_.data(), bytes_.size()))
            fail("the checksum of a message does not match");
    }

    [[noreturn]] void fail(const std::string& what) const { throw core::Error(from_ + ": " + what); }
    const std::string& from() const { return from_; }

    template <class T>
    T take() {
        static_assert(std::is_arithmetic_v<T> && !std::is_same_v<T, bool>);
        T value;
        std::memcpy(&value, raw(sizeof(T)).data(), sizeof(T));
        return value;
    }
    bool take_flag(const char* what) { return take_one_of<uint8_t>(1, what) != 0; }
    template <class T>
    T take_one_of(uint8_t most, const char* what) {
        const auto value = take<uint8_t>();
        if (value > most)
            fail(core::text("%s is %u; at most %u is known", what, unsigned(value), unsigned(most)));
        return T(value);
    }
    double take_number(double low, double high, const char* what) {
        const auto value = take<double>();
        if (!(value >= low && value <= high))
            fail(core::text("%s is %g; %g to %g is right", what, value, low, high));
        return value;
    }
    glm::dvec3 take_vector() {
        const auto x = take<double>(), y = take<double>(), z = take<double>();
        return {x, y, z};
    }
    Bytes take_bytes() {
        const auto bytes = raw(take<uint32_t>());
        return {bytes.begin(), bytes.end()};
    }
    std::string take_text(size_t most = kMostText) {
        const auto bytes = raw(take<uint32_t>());
        if (bytes.size() > most) fail("a text is too long");
        return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
    }
    std::vector<uint64_t> take_leaves() {
        const auto count = take<uint32_t>();
        if (count > kMostDeletions)
            fail(core::text("%u leaves to delete; at most %u is right", count, kMostDeletions));
        const auto bytes = raw(count * sizeof(uint64_t));
        std::vector<uint64_t> leaves(count);
        if (count > 0) std::memcpy(leaves.data(), bytes.data(), bytes.size());
        return leaves;
    }
    void finish() const {
        if (at_ != bytes_.size()) fail("a message is too long");
    }

  private:
    std::span<const std::byte> raw(size_t size) {
        if (size > bytes_.size() - at_) fail("a message is cut off");
        at_ += size;
        return bytes_.subspan(at_ - size, size);
    }

    std::span<const std::byte> bytes_;
    std::string from_;
    size_t at_ = 0;
};

void put(Writer& out, const Frustum& f) {
    const geom::View& v = f.view;
    out.put(f.projection);
    out.put(uint8_t((v.near ? kHasNear : 0) | (v.far ? kHasFar : 0)));
    out.put(uint16_t(v.width)), out.put(uint16_t(v.height));
    out.put(v.focal_px), out.put(v.shift_px.x), out.put(v.shift_px.y);
    for (const glm::dvec3* axis : {&v.eye, &v.right, &v.down, &v.forward}) out.put(*axis);
    out.put(v.near.value_or(0)), out.put(v.far.value_or(0));
}

Frustum take_frustum(Reader& in) {
    Frustum f;
    geom::View& v = f.view;
    f.projection = in.take_one_of<Projection>(1, "the projection");
    const auto limits = in.take_one_of<uint8_t>(kHasNear | kHasFar, "what limits depths");
    v.width = in.take<uint16_t>(), v.height = in.take<uint16_t>();
    v.focal_px = in.take<double>(), v.shift_px.x = in.take<double>(), v.shift_px.y = in.take<double>();
    for (glm::dvec3* axis : {&v.eye, &v.right, &v.down, &v.forward}) *axis = in.take_vector();
    const auto near = in.take<double>(), far = in.take<double>();
    if (limits & kHasNear) v.near = near;
    if (limits & kHasFar) v.far = far;
    if (std::bit_cast<uint64_t>(v.near ? 0.0 : near) != 0 || std::bit_cast<uint64_t>(v.far ? 0.0 : far) != 0)
        in.fail("a depth that does not count is not 0");
    check(f, in.from());
    return f;
}

void put(Writer& out, const Welcome& w) {
    out.put(w.version);
    out.put(w.bounds.is_empty);
    out.put(w.bounds.low), out.put(w.bounds.high);
    out.put(w.most_pixels), out.put(w.most_points);
    out.put(w.scene), out.put(w.sampler);
}

Welcome take_welcome(Reader& in) {
    Welcome w;
    w.version = in.take<uint16_t>();
    if (w.version != kProtocolVersion)
        in.fail(core::text("speaks version %u of the protocol, this program %u", unsigned(w.version),
                           unsigned(kProtocolVersion)));
    w.bounds.is_empty = in.take_flag("the box");
    w.bounds.low = in.take_vector(), w.bounds.high = in.take_vector();
    for (int k = 0; k < 3; ++k)
        if (!(w.bounds.low[k] >= -kMostCoordinate && w.bounds.low[k] <= w.bounds.high[k] &&
              w.bounds.high[k] <= kMostCoordinate))
            in.fail("the scene's box is not one");
    w.most_pixels = in.take<uint64_t>(), w.most_points = in.take<uint64_t>();
    w.scene = in.take_text(), w.sampler = in.take_text();
    return w;
}

void put(Writer& out, const Request& r) {
    out.put(r.id), out.put(r.stamp);
    put(out, r.frustum);
    out.put(r.footprint_px), out.put(r.bound_px);
    out.put(r.codec), out.put(r.elimination);
    out.put(r.epsilon);
    out.put(r.wants_normals);
    out.put(r.last_answer), out.put(r.octree_checksum);
    out.put(std::span<const uint64_t>(r.deletions));
}

Request take_request(Reader& in) {
    Request r;
    r.id = in.take<uint64_t>(), r.stamp = in.take<uint64_t>();
    r.frustum = take_frustum(in);
    r.footprint_px = in.take_number(1e-3, kMostFootprint, "the footprint");
    r.bound_px = in.take_number(0, kMostBound, "the bound of depths");
    r.codec = in.take_one_of<Codec>(1, "the codec");
    r.elimination = in.take_one_of<Elimination>(2, "the rule of elimination");
    r.epsilon = in.take_number(0, kMostCoordinate, "epsilon");
    r.wants_normals = in.take_flag("the wish for normals");
    r.last_answer = in.take<uint64_t>(), r.octree_checksum = in.take<uint64_t>();
    r.deletions = in.take_leaves();
    return r;
}

void put(Writer& out, const SampleCounts& c) {
    for (const uint64_t n : {c.bytes, c.bytes_touched, c.clusters, c.clusters_touched, c.clusters_hidden,
                             c.triangles_tested, c.triangles_drawn})
        out.put(n);
    out.put(c.ms);
}

SampleCounts take_counts(Reader& in) {
    SampleCounts c;
    for (uint64_t* n : {&c.bytes, &c.bytes_touched, &c.clusters, &c.clusters_touched, &c.clusters_hidden,
                        &c.triangles_tested, &c.triangles_drawn})
        *n = in.take<uint64_t>();
    c.ms = in.take_number(0, 1e12, "the time of sampling");
    return c;
}

void put(Writer& out, const Answer& a) {
    out.put(a.id), out.put(a.stamp);
    out.put(a.starts_anew);
    out.put(std::span<const uint64_t>(a.deleted));
    out.put(std::span<const std::byte>(a.replaced));
    put(out, a.frustum);
    out.put(a.coding.bits), out.put(a.coding.base);
    out.put(a.footprint_px);
    out.put(a.has_normals), out.put(a.codec);
    out.put(std::span<const std::byte>(a.image));
    out.put(a.octree_checksum);
    out.put(a.samples), out.put(a.samples_kept);
    put(out, a.counts);
    out.put(a.sample_ms), out.put(a.eliminate_ms), out.put(a.encode_ms);
}

DepthCoding take_coding(Reader& in, Projection projection) {
    DepthCoding coding{.projection = projection};
    coding.bits = in.take<int32_t>(), coding.base = in.take<int64_t>();
    if (!is_valid(coding))
        in.fail(core::text("depths of %d bits counted from %lld are none", coding.bits,
                           static_cast<long long>(coding.base)));
    return coding;
}

Answer take_answer(Reader& in) {
    Answer a;
    a.id = in.take<uint64_t>(), a.stamp = in.take<uint64_t>();
    a.starts_anew = in.take_flag("whether the answer starts anew");
    a.deleted = in.take_leaves();
    a.replaced = in.take_bytes();
    a.frustum = take_frustum(in);
    a.coding = take_coding(in, a.frustum.projection);
    a.footprint_px = in.take_number(1e-3, kMostFootprint, "the footprint");
    a.has_normals = in.take_flag("whether there are normals");
    a.codec = in.take_one_of<Codec>(1, "the codec");
    a.image = in.take_bytes();
    a.octree_checksum = in.take<uint64_t>();
    a.samples = in.take<uint64_t>(), a.samples_kept = in.take<uint64_t>();
    a.counts = take_counts(in);
    for (float* ms : {&a.sample_ms, &a.eliminate_ms, &a.encode_ms}) {
        *ms = in.take<float>();
        if (!(*ms >= 0 && *ms <= 1e12f)) in.fail("a time is out of range");
    }
    return a;
}

Bytes format_one(const Welcome& m) {
    Writer out(Type::welcome);
    put(out, m);
    return std::move(out).finish();
}

Bytes format_one(const Request& m) {
    Writer out(Type::request);
    put(out, m);
    return std::move(out).finish();
}

Bytes format_one(const Deletions& m) {
    Writer out(Type::deletions);
    out.put(std::span<const uint64_t>(m.leaves));
    return std::move(out).finish();
}

Bytes format_one(const Answer& m) {
    Writer out(Type::answer);
    put(out, m);
    return std::move(out).finish();
}

Bytes format_one(const Refusal& m) {
    Writer out(Type::refusal);
    out.put(m.id), out.put(m.reason);
    return std::move(out).finish();
}

Bytes format_one(const StatusQuery&) {
    return Writer(Type::status_query).finish();
}

Bytes format_one(const Status& m) {
    Writer out(Type::status);
    out.put(m.counters, kMostCounters);
    return std::move(out).finish();
}

Message take_message(Reader& in) {
    switch (Type(in.take<uint8_t>())) {
        case Type::welcome:
            return take_welcome(in);
        case Type::request:
            return take_request(in);
        case Type::deletions:
            return Deletions{in.take_leaves()};
        case Type::answer:
            return take_answer(in);
        case Type::refusal: {
            const auto id = in.take<uint64_t>();
            return Refusal{id, in.take_text()};
        }
        case Type::status_query:
            return StatusQuery{};
        case Type::status:
            return Status{in.take_text(kMostCounters)};
    }
    in.fail("a message of an unknown type");
}

}  // namespace

std::vector<std::byte> format(const Message& message) {
    return std::visit([](const auto& m) { return format_one(m); }, message);
}

Message parse(std::span<const std::byte> bytes, const std::string& from) {
    Reader in(bytes, from);
    Message message = take_message(in);
    in.finish();
    return message;
}

DepthImage image_of(const Answer& answer) {
    DepthImage image;
    image.frustum = answer.frustum, image.coding = answer.coding, image.footprint_px = answer.footprint_px;
    decode(answer.image, answer.codec, answer.has_normals, image);
    return image;
}

}  // namespace ppve
