#include "ppve/sample/clusters.h"

#include <xxhash.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

#include "core/bytes.h"
#include "core/error.h"
#include "core/parallel.h"
#include "ppve/sample/light.h"
#include "render/raster.h"
#include "render/shading.h"

namespace ppve {

namespace {

// The file: see ppve-clusters(5).
constexpr std::array<char, 8> kMagic = {'p', 'p', 'v', 'e', 'c', 'l', 'u', 's'};
constexpr uint32_t kVersion = 1;
constexpr size_t kHeaderBytes = 64, kAlignment = 64;
constexpr size_t kMostName = 200;
static_assert(sizeof(Clusters::Entry) == 48);

uint64_t aligned(uint64_t offset) {
    return (offset + kAlignment - 1) / kAlignment * kAlignment;
}

uint32_t padded(uint32_t vertices) {
    constexpr uint32_t kPadding = ClusterView::kVertexPadding;
    return (vertices + kPadding - 1) / kPadding * kPadding;
}

constexpr uint64_t kVertexBytes = 3 * sizeof(float) + 2 * sizeof(uint32_t) + sizeof(uint16_t);

uint64_t size_of(uint32_t vertices, uint32_t triangles) {
    return padded(vertices) * kVertexBytes + triangles * 3 * sizeof(uint16_t);
}

// 21 bits of each coordinate, three apart.
uint64_t spread(uint64_t v) {
    v = (v | v << 32) & 0x001f00000000ffff;
    v = (v | v << 16) & 0x001f0000ff0000ff;
    v = (v | v << 8) & 0x100f00f00f00f00f;
    v = (v | v << 4) & 0x10c30c30c30c30c3;
    return (v | v << 2) & 0x1249249249249249;
}

struct Placed {
    uint64_t morton;
    uint32_t triangle;
    bool operator<(const Placed& o) const {
        return morton != o.morton ? morton < o.morton : triangle < o.triangle;
    }
};

std::vector<Placed> in_morton_order(const mesh::Mesh& mesh) {
    glm::dvec3 low(std::numeric_limits<double>::infinity()), high(-low);
    for (const glm::vec3& p : mesh.positions)
        low = glm::min(low, glm::dvec3(p)), high = glm::max(high, glm::dvec3(p));
    const glm::dvec3 extent = high - low;
    const double side = std::max({extent.x, extent.y, extent.z});
    const double scale = side > 0 ? double((1 << 21) - 1) / side : 0;
    std::vector<Placed> order(mesh.triangles.size());
    core::parallel_pieces(order.size(), 1 << 16, [&](size_t begin, size_t end) {
        for (size_t t = begin; t < end; ++t) {
            const glm::u32vec3 c = mesh.triangles[t];
            const glm::dvec3 middle = (glm::dvec3(mesh.positions[c.x]) + glm::dvec3(mesh.positions[c.y]) +
                                       glm::dvec3(mesh.positions[c.z])) /
                                      3.0;
            const glm::dvec3 cell = (middle - low) * scale;
            order[t] = {
                spread(uint64_t(cell.x)) | spread(uint64_t(cell.y)) << 1 | spread(uint64_t(cell.z)) << 2,
                uint32_t(t)};
        }
    });
    std::sort(order.begin(), order.end());
    return order;
}

// The vertices that a cluster's triangles use, in the mesh's numbers and order.
std::vector<uint32_t> vertices_of(const mesh::Mesh& mesh, std::span<const Placed> triangles) {
    std::vector<uint32_t> used;
    used.reserve(3 * triangles.size());
    for (const Placed& placed : triangles)
        for (int k = 0; k < 3; ++k) used.push_back(mesh.triangles[placed.triangle][k]);
    std::sort(used.begin(), used.end());
    used.erase(std::unique(used.begin(), used.end()), used.end());
    return used;
}

// Two unit vectors at right angles to `normal`, and to each other.
std::array<glm::vec3, 2> tangents_of(const glm::vec3& normal) {
    const glm::vec3 n = normal == glm::vec3(0) ? glm::vec3(0, 0, 1) : normal;
    const glm::vec3 least = std::abs(n.x) < 0.6f ? glm::vec3(1, 0, 0) : glm::vec3(0, 1, 0);
    const glm::vec3 t = glm::normalize(glm::cross(n, least));
    return {t, glm::cross(n, t)};
}

// Squares about the discs of a cloud.
mesh::Mesh squares_of(const mesh::Mesh& cloud) {
    const size_t count = cloud.positions.size();
    if (count > std::numeric_limits<uint32_t>::max() / 4)
        throw core::Error("more points than can be sampled: " + std::to_string(count));
    mesh::Mesh squares;
    squares.origin = cloud.origin;
    squares.positions.resize(4 * count);
    if (!cloud.normals.empty()) squares.normals.resize(4 * count);
    if (!cloud.colours.empty()) squares.colours.resize(4 * count);
    squares.triangles.resize(2 * count);
    core::parallel_pieces(count, 1 << 14, [&](size_t begin, size_t end) {
        for (size_t p = begin; p < end; ++p) {
            const glm::vec3 normal = cloud.normals.empty() ? glm::vec3(0) : cloud.normals[p];
            const auto [u, v] = tangents_of(normal);
            const float r = cloud.radii.empty() ? 0 : cloud.radii[p];
            for (int k = 0; k < 4; ++k) {
                const float along = k == 1 || k == 2 ? r : -r, across = k >= 2 ? r : -r;
                squares.positions[4 * p + size_t(k)] = cloud.positions[p] + along * u + across * v;
                if (!cloud.normals.empty()) squares.normals[4 * p + size_t(k)] = normal;
                if (!cloud.colours.empty()) squares.colours[4 * p + size_t(k)] = cloud.colours[p];
            }
            const uint32_t first = uint32_t(4 * p);
            squares.triangles[2 * p] = {first, first + 1, first + 2};
            squares.triangles[2 * p + 1] = {first, first + 2, first + 3};
        }
    });
    return squares;
}

// Where the parts of a cluster with so many vertices and triangles are, in its bytes.
ClusterView view_of(const std::byte* bytes, uint32_t vertices, uint32_t triangles) {
    const uint32_t n = padded(vertices);
    const auto floats = reinterpret_cast<const float*>(bytes);
    const auto colours = reinterpret_cast<const uint32_t*>(floats + 3 * size_t(n));
    const auto normals = reinterpret_cast<const uint16_t*>(colours + 2 * size_t(n));
    return {vertices, triangles,   floats,  floats + n, floats + 2 * size_t(n),
            colours,  colours + n, normals, normals + n};
}

// Fills the bytes of one cluster, and the box of its entry.
struct ClusterWriter {
    const mesh::Mesh& mesh;
    const std::vector<glm::vec3>& normals;

    void write(std::span<const Placed> triangles, std::span<const uint32_t> used, std::span<std::byte> out,
               Clusters::Entry& entry) const {
        const ClusterView at = view_of(out.data(), entry.vertices, entry.triangles);
        std::fill(std::begin(entry.low), std::end(entry.low), std::numeric_limits<float>::infinity());
        std::fill(std::begin(entry.high), std::end(entry.high), -std::numeric_limits<float>::infinity());
        for (size_t v = 0; v < padded(entry.vertices); ++v)
            put_vertex(used[std::min(v, used.size() - 1)], v, at, entry);
        auto corners = const_cast<uint16_t*>(at.corners);
        for (const Placed& placed : triangles)
            for (int k = 0; k < 3; ++k) {
                const auto found =
                    std::lower_bound(used.begin(), used.end(), mesh.triangles[placed.triangle][k]);
                *corners++ = uint16_t(found - used.begin());
            }
        entry.checksum = XXH3_64bits(out.data(), out.size());
    }

  private:
    // The view's arrays lie in bytes that are being written.
    void put_vertex(uint32_t from, size_t to, const ClusterView& at, Clusters::Entry& entry) const {
        const glm::vec3 p = mesh.positions[from];
        const float* const axes[3] = {at.x, at.y, at.z};
        for (int k = 0; k < 3; ++k) {
            const_cast<float*>(axes[k])[to] = p[k];
            entry.low[k] = std::min(entry.low[k], p[k]), entry.high[k] = std::max(entry.high[k], p[k]);
        }
        const glm::vec3 material =
            mesh.colours.empty() ? glm::vec3(render::kGreyMaterial) : glm::vec3(mesh.colours[from]);
        const_cast<uint32_t*>(at.lit)[to] = lit_colour(material, normals[from]);
        const_cast<uint32_t*>(at.material)[to] = pack_colour(material);
        const_cast<uint16_t*>(at.normal)[to] = octahedral_code(normals[from]);
    }
};

}  // namespace

Clusters::Clusters(const mesh::Mesh& mesh) {
    if (mesh.is_cloud()) {
        if (mesh.positions.empty()) throw core::Error("nothing to sample: no triangle and no point");
        *this = Clusters(squares_of(mesh));
        return;
    }
    origin_ = mesh.origin, triangles_ = mesh.triangles.size();
    const std::vector<Placed> order = in_morton_order(mesh);
    const size_t count = (order.size() + kClusterTriangles - 1) / kClusterTriangles;
    const auto triangles_in = [&](size_t c) {
        const size_t begin = c * kClusterTriangles;
        return std::span(order).subspan(begin, std::min<size_t>(kClusterTriangles, order.size() - begin));
    };
    entries_.resize(count);
    std::vector<std::vector<uint32_t>> used(count);
    core::parallel_for(count, [&](size_t c) {
        used[c] = vertices_of(mesh, triangles_in(c));
        entries_[c].vertices = uint32_t(used[c].size()),
        entries_[c].triangles = uint32_t(triangles_in(c).size());
    });
    uint64_t end = aligned(kHeaderBytes + count * sizeof(Entry) + sizeof(uint64_t));
    for (Entry& e : entries_) e.offset = end, end = aligned(end + size_of(e.vertices, e.triangles));
    own_.resize(end);
    const std::vector<glm::vec3> normals = render::filled_normals(mesh);
    const ClusterWriter writer{mesh, normals};
    core::parallel_for(count, [&](size_t c) {
        Entry& e = entries_[c];
        writer.write(triangles_in(c), used[c],
                     std::span(own_).subspan(e.offset, size_of(e.vertices, e.triangles)), e);
    });
    core::ByteWriter head;
    for (const char c : kMagic) head.put(c);
    head.put(kVersion), head.put(uint32_t(count)), head.put(triangles_), head.put(uint64_t(own_.size()));
    for (int k = 0; k < 3; ++k) head.put(origin_[k]);
    head.put(uint64_t(0));
    std::memcpy(own_.data(), head.bytes.data(), head.bytes.size());
    std::memcpy(own_.data() + kHeaderBytes, entries_.data(), count * sizeof(Entry));
    const uint64_t sum = XXH3_64bits(own_.data(), kHeaderBytes + count * sizeof(Entry));
    std::memcpy(own_.data() + kHeaderBytes + count * sizeof(Entry), &sum, sizeof(sum));
    bytes_ = own_;
}

Clusters::Clusters(core::InputFile file)
    : name_(file.name()), file_(std::move(file)), bytes_(file_->bytes()) {
    read_header();
    is_checked_ = std::make_unique<std::atomic<uint8_t>[]>(entries_.size());
}

bool Clusters::is_file(std::span<const std::byte> bytes) {
    return bytes.size() >= kMagic.size() && std::memcmp(bytes.data(), kMagic.data(), kMagic.size()) == 0;
}

void Clusters::write(core::OutputFile& out) const {
    out.write(bytes_);
}

void Clusters::read_header() {
    const auto fail = [&](const std::string& what) -> void { throw core::Error(name_ + ": " + what); };
    if (!is_file(bytes_)) fail("not a file of clusters");
    core::ByteReader in(bytes_.subspan(kMagic.size()), name_);
    const auto version = in.take<uint32_t>();
    if (version != kVersion) fail(core::text("format version %u, this program reads %u", version, kVersion));
    const auto count = in.take<uint32_t>();
    triangles_ = in.take<uint64_t>();
    const auto size = in.take<uint64_t>();
    for (int k = 0; k < 3; ++k) origin_[k] = in.take<double>();
    if (size != bytes_.size())
        fail(core::text("%zu bytes, the header says %llu", bytes_.size(),
                        static_cast<unsigned long long>(size)));
    const uint64_t table = kHeaderBytes + uint64_t(count) * sizeof(Entry);
    if (count == 0 || table + sizeof(uint64_t) > bytes_.size())
        fail(core::text("a table of %u clusters does not fit", count));
    uint64_t sum;
    std::memcpy(&sum, bytes_.data() + table, sizeof(sum));
    if (sum != XXH3_64bits(bytes_.data(), table)) fail("the header's checksum does not match");
    entries_.resize(count);
    std::memcpy(entries_.data(), bytes_.data() + kHeaderBytes, count * sizeof(Entry));
    uint64_t triangles = 0;
    for (size_t c = 0; c < entries_.size(); ++c) {
        const Entry& e = entries_[c];
        triangles += e.triangles;
        const bool has_size = e.vertices >= 1 && e.vertices <= ClusterView::kMostVertices &&
                              e.triangles >= 1 && e.triangles <= kClusterTriangles;
        const bool is_inside = e.offset % kAlignment == 0 && e.offset >= table && e.offset <= bytes_.size() &&
                               (!has_size || size_of(e.vertices, e.triangles) <= bytes_.size() - e.offset);
        bool has_box = true;
        for (int k = 0; k < 3; ++k)
            has_box = has_box && std::isfinite(e.low[k]) && std::isfinite(e.high[k]) && e.low[k] <= e.high[k];
        if (!has_size || !is_inside || !has_box)
            fail(core::text("cluster %zu: does not fit into the file", c));
    }
    if (triangles != triangles_) fail("the clusters' triangles are not as many as the header says");
    for (int k = 0; k < 3; ++k)
        if (!(std::abs(origin_[k]) <= kMostCoordinate)) fail("the origin is out of range");
}

Box Clusters::bounds() const {
    Box box;
    for (const Entry& e : entries_) {
        box.add(origin_ + glm::dvec3(e.low[0], e.low[1], e.low[2]));
        box.add(origin_ + glm::dvec3(e.high[0], e.high[1], e.high[2]));
    }
    return box;
}

uint64_t Clusters::bytes_of(size_t cluster) const {
    return size_of(entries_[cluster].vertices, entries_[cluster].triangles);
}

ClusterView Clusters::layout_of(size_t cluster) const {
    const Entry& e = entries_[cluster];
    return view_of(bytes_.data() + e.offset, e.vertices, e.triangles);
}

void Clusters::check(size_t cluster) const {
    const auto fail = [&](const char* what) {
        throw core::Error(core::text("%.*s: cluster %zu: %s", int(kMostName), name_.c_str(), cluster, what));
    };
    const Entry& e = entries_[cluster];
    if (XXH3_64bits(bytes_.data() + e.offset, bytes_of(cluster)) != e.checksum)
        fail("the checksum does not match");
    const ClusterView view = layout_of(cluster);
    for (size_t k = 0; k < 3 * size_t(view.triangles); ++k)
        if (view.corners[k] >= view.vertices) fail("a triangle has a corner that is not there");
    const float* const axes[3] = {view.x, view.y, view.z};
    for (int k = 0; k < 3; ++k)
        for (size_t v = 0; v < padded(view.vertices); ++v)
            if (!(axes[k][v] >= e.low[k] && axes[k][v] <= e.high[k])) fail("a vertex is outside its box");
}

ClusterView Clusters::view(size_t cluster) const {
    // Those that were made here hold what they promise.  Two threads that check at once come to the same.
    if (is_checked_ && !is_checked_[cluster].load(std::memory_order_relaxed)) {
        check(cluster);
        is_checked_[cluster].store(1, std::memory_order_relaxed);
    }
    return layout_of(cluster);
}

}  // namespace ppve
