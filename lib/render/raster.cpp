#include "render/raster.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/parallel.h"
#include "render/orientation.h"
#include "render/shading.h"

namespace render {

namespace {

constexpr int kTile = 64;              // pixels on a side: depth, index and weights of a tile stay in L2
constexpr size_t kMostPieces = 64;     // triangles are sorted into tiles in so many parts at most ...
constexpr size_t kLeastPiece = 4096;   // ... of so many triangles at least
constexpr size_t kVertexGrain = 4096;  // vertices handed to a thread at a time
constexpr uint32_t kPrefetch = 4;      // triangles looked ahead: -20% on the draw pass of 871,414

// A determinant of three vectors, each component rounded a handful of times, is off by less than this times
// the product of their magnitudes: six products, each with at most six roundings of 2^-53, and some room.
constexpr double kRounding = 48 * 0x1p-53;

// A vertex in view space, in units of the frame's scale: (focal_px * x, focal_px * y, z).  The ray through
// pixel centre (X, Y), counted from the middle of the frame, is (X, Y, 1) in these coordinates.
using Ray = glm::dvec3;

// Where a vertex falls among the pixel centres: those at or right of (below) it begin at `first`, those at or
// left of (above) it end at `last`, give or take the rounding of the projection.  The ends are kept as ~last,
// so that the box of a triangle is the least of each of its vertices' four numbers.
struct Span {
    int32_t first_x, first_y, not_last_x, not_last_y;
};

// first_x of a vertex at or behind the eye, which has no place on the screen.
constexpr int32_t kBehind = std::numeric_limits<int32_t>::min();

Span least(const Span& a, const Span& b) {
    return {std::min(a.first_x, b.first_x), std::min(a.first_y, b.first_y),
            std::min(a.not_last_x, b.not_last_x), std::min(a.not_last_y, b.not_last_y)};
}

// Pixels [first_x, last_x] x [first_y, last_y]; empty where last < first.
struct PixelBox {
    int first_x, first_y, last_x, last_y;
    bool empty() const { return last_x < first_x || last_y < first_y; }
};

PixelBox intersect(const PixelBox& a, const PixelBox& b) {
    return {std::max(a.first_x, b.first_x), std::max(a.first_y, b.first_y), std::min(a.last_x, b.last_x),
            std::min(a.last_y, b.last_y)};
}

// The frame's raster and what follows from its size and its place in the picture.
struct Raster {
    int width, height;
    int tiles_x, tiles_y;
    int left, top;         // first pixel
    glm::dvec2 principal;  // where X and Y are 0
    double reach;          // no pixel centre has |X| or |Y| above it
    double slack;  // pixels by which a projection may be off inside the frame, generously
    double near, far;  // depths, in the frame's scale, between which something is drawn

    Raster(const geom::View& view, double scale)
        : width(view.width),
          height(view.height),
          tiles_x((width + kTile - 1) / kTile),
          tiles_y((height + kTile - 1) / kTile),
          left(view.margins.left),
          top(view.margins.top),
          principal(view.principal()),
          reach(std::max(std::max(std::abs(side_x(-1)), std::abs(side_x(1))),
                         std::max(std::abs(side_y(-1)), std::abs(side_y(1))))),
          slack(reach * 0x1p-40),
          near(view.near.value_or(0) * scale),
          far(view.far.value_or(std::numeric_limits<double>::infinity()) * scale) {}

    PixelBox all() const { return {0, 0, width - 1, height - 1}; }
    PixelBox tile(int tx, int ty) const {
        return intersect({tx * kTile, ty * kTile, tx * kTile + kTile - 1, ty * kTile + kTile - 1}, all());
    }
    // X and Y of pixel centres, and of the raster's left (-1) or right (1), upper or lower side.
    double centre_x(int i) const { return left + i + 0.5 - principal.x; }
    double centre_y(int j) const { return top + j + 0.5 - principal.y; }
    double side_x(double sign) const { return left + (sign > 0 ? width : 0) - principal.x; }
    double side_y(double sign) const { return top + (sign > 0 ? height : 0) - principal.y; }
};

// The first of `count` pixels along an axis whose centre is at or after `place` (pixels from the edge of the
// frame), and the last whose centre is at or before it; `count` and -1 where there is none.  Written so that
// anything, NaN too, gives numbers in these ranges.
int32_t first_after(double place, int count) {
    if (!(place > 0.5)) return 0;
    if (place > count - 0.5) return count;
    const int32_t before = int32_t(place - 0.5);
    return before + (before + 0.5 < place);
}

int32_t last_before(double place, int count) {
    if (!(place < count - 0.5)) return count - 1;
    return place < 0.5 ? -1 : int32_t(place - 0.5);
}

Span span_of(const Raster& raster, const Ray& ray) {
    if (!(ray.z > 0)) return {kBehind, 0, 0, 0};
    const double inverse = 1 / ray.z;
    const double x = ray.x * inverse - raster.side_x(-1), y = ray.y * inverse - raster.side_y(-1);
    return {first_after(x - raster.slack, raster.width), first_after(y - raster.slack, raster.height),
            ~last_before(x + raster.slack, raster.width), ~last_before(y + raster.slack, raster.height)};
}

// True if v lies outside the side of the view pyramid where sign * (coordinate - place * z) = 0, beyond
// doubt.
bool beyond(double coordinate, double z, double place, double sign) {
    const double margin = kRounding * (std::abs(coordinate) + std::abs(place * z));
    return sign * (coordinate - place * z) > margin;
}

// The pixels that a triangle reaching behind the eye may cover: none, where one side of the view pyramid
// (which goes through the eye, so the test holds behind it too) has it wholly outside, else all.
PixelBox box_across_eye(const Raster& raster, const Ray& a, const Ray& b, const Ray& c) {
    const PixelBox none{0, 0, -1, -1};
    if (a.z <= 0 && b.z <= 0 && c.z <= 0) return none;
    for (const double sign : {-1.0, 1.0}) {
        const double w = raster.side_x(sign), h = raster.side_y(sign);
        if (beyond(a.x, a.z, w, sign) && beyond(b.x, b.z, w, sign) && beyond(c.x, c.z, w, sign)) return none;
        if (beyond(a.y, a.z, h, sign) && beyond(b.y, b.z, h, sign) && beyond(c.y, c.z, h, sign)) return none;
    }
    return raster.all();
}

// A triangle ready to be drawn.  Edge i is opposite vertex i; value(i, X, Y) > 0 where the ray through (X, Y)
// passes on the triangle's side of it.  A ray inside all edges meets the triangle before the eye, because the
// values have been given the sign of the triangle's determinant, and they are the perspective-correct weights
// of the vertices.
struct TriangleSetup {
    const Ray* vertices[3];
    glm::dvec3 normals[3];     // sign * cross product of the edge's ends
    glm::dvec3 rounding;       // value(i) is off by at most rounding[i]
    double sign;               // 1 or -1
    double nearest, farthest;  // depths

    // False for a triangle that is seen edge-on or has no area: it covers nothing.
    [[gnu::always_inline]] bool set(const Raster& raster, const Ray& a, const Ray& b, const Ray& c) {
        vertices[0] = &a, vertices[1] = &b, vertices[2] = &c;
        const double ma = magnitude(raster, a), mb = magnitude(raster, b), mc = magnitude(raster, c);
        normals[0] = glm::cross(b, c), normals[1] = glm::cross(c, a), normals[2] = glm::cross(a, b);
        rounding[0] = kRounding * mb * mc, rounding[1] = kRounding * mc * ma,
        rounding[2] = kRounding * ma * mb;
        const double det = glm::dot(normals[0], a);
        const double doubt = rounding[0] * ma / raster.reach;
        sign = std::copysign(1.0, det);
        if (!(std::abs(det) > doubt)) {
            sign = orientation(a, b, c);
            if (sign == 0) return false;
        }
        for (glm::dvec3& normal : normals) normal *= sign;
        nearest = std::max(0.0, std::min(std::min(a.z, b.z), c.z));
        farthest = std::max(std::max(a.z, b.z), c.z);
        return true;
    }

    double value(int edge, double x, double y) const {
        return normals[edge].x * x + (normals[edge].y * y + normals[edge].z);
    }

    // `values`: those at (x, y).  One branch that cannot be foreseen instead of three: -15% on the draw pass.
    bool inside(const glm::dvec3& values, double x, double y) const {
        if (least(values + rounding) < 0) return false;
        if (least(values - rounding) > 0) return true;
        return inside_exactly(0, x, y) && inside_exactly(1, x, y) && inside_exactly(2, x, y);
    }

    // A ray on the edge counts as if it were moved to the right by an infinitely small amount, and down by
    // one infinitely smaller.
    [[gnu::noinline]] bool inside_exactly(int edge, double x, double y) const {
        const Ray &from = *vertices[(edge + 1) % 3], &to = *vertices[(edge + 2) % 3];
        int side = orientation(from, to, {x, y, 1});
        if (side == 0) side = orientation(from, to, {1, 0, 0});
        if (side == 0) side = orientation(from, to, {0, 1, 0});
        return side * sign > 0;
    }

    // False only if no pixel of `box` can be covered: all its corners are outside one edge.
    bool may_touch(const Raster& raster, const PixelBox& box) const {
        const double x[2] = {raster.centre_x(box.first_x), raster.centre_x(box.last_x)};
        const double y[2] = {raster.centre_y(box.first_y), raster.centre_y(box.last_y)};
        for (int edge = 0; edge < 3; ++edge) {
            const double most = std::max(std::max(value(edge, x[0], y[0]), value(edge, x[1], y[0])),
                                         std::max(value(edge, x[0], y[1]), value(edge, x[1], y[1])));
            if (most < -rounding[edge]) return false;
        }
        return true;
    }

  private:
    static double least(const glm::dvec3& v) { return std::min(std::min(v.x, v.y), v.z); }
    static double magnitude(const Raster& raster, const Ray& v) {
        return std::max(std::max(std::abs(v.x), std::abs(v.y)), raster.reach * std::abs(v.z));
    }
};

// What shows in the pixels of one tile.
struct TileBuffer {
    double z[kTile * kTile];
    uint32_t triangle[kTile * kTile];
    float weight_b[kTile * kTile], weight_c[kTile * kTile];  // of the triangle's second and third vertex

    TileBuffer() { std::fill(std::begin(z), std::end(z), std::numeric_limits<double>::infinity()); }
};

void draw_triangle(const Raster& raster, const TriangleSetup& setup, const PixelBox& box,
                   const PixelBox& tile, uint32_t triangle, TileBuffer& out) {
    if (setup.farthest < raster.near || setup.nearest > raster.far) return;
    for (int j = box.first_y; j <= box.last_y; ++j) {
        const double y = raster.centre_y(j);
        for (int i = box.first_x; i <= box.last_x; ++i) {
            const int at = (j - tile.first_y) * kTile + (i - tile.first_x);
            if (!(setup.nearest < out.z[at])) continue;
            const double x = raster.centre_x(i);
            const glm::dvec3 values{setup.value(0, x, y), setup.value(1, x, y), setup.value(2, x, y)};
            if (!setup.inside(values, x, y)) continue;
            // Inside by the exact test, a value may still be rounded to just below 0; a sliver's three may
            // all be 0.
            const glm::dvec3 weights = glm::max(values, 0.0);
            const double sum = weights.x + weights.y + weights.z;
            const double inverse = sum > 0 ? 1 / sum : 0;
            const double z = (weights.x * setup.vertices[0]->z + weights.y * setup.vertices[1]->z +
                              weights.z * setup.vertices[2]->z) *
                             inverse;
            const double shown = std::clamp(z, setup.nearest, setup.farthest);
            if (!(shown < out.z[at]) || shown < raster.near || shown > raster.far) continue;
            out.z[at] = shown;
            out.triangle[at] = triangle;
            out.weight_b[at] = float(weights.y * inverse);
            out.weight_c[at] = float(weights.z * inverse);
        }
    }
}

// Area-weighted vertex normals, unit length, or zero where no face with an area is at the vertex.  In double,
// because in float the cross products of a mesh of 1e-20 across vanish.
std::vector<glm::vec3> area_weighted_normals(const mesh::Mesh& mesh) {
    std::vector<glm::dvec3> sums(mesh.positions.size(), glm::dvec3(0));
    for (const glm::u32vec3& t : mesh.triangles) {
        const glm::dvec3 a = mesh.positions[t[0]], b = mesh.positions[t[1]], c = mesh.positions[t[2]];
        const glm::dvec3 area = glm::cross(b - a, c - a);
        for (int k = 0; k < 3; ++k) sums[t[k]] += area;
    }
    std::vector<glm::vec3> normals(sums.size());
    for (size_t v = 0; v < sums.size(); ++v) {
        const double length = glm::length(sums[v]);
        normals[v] = length > 0 ? glm::vec3(sums[v] / length) : glm::vec3(0);
    }
    return normals;
}

bool has_unknown_normal(const mesh::Mesh& mesh) {
    return mesh.normals.empty() || std::any_of(mesh.normals.begin(), mesh.normals.end(),
                                               [](const glm::vec3& n) { return n == glm::vec3(0); });
}

// The sum of weights[k] * attribute[t[k]].
template <class Attribute>
glm::vec3 interpolate(const std::vector<Attribute>& attribute, const glm::u32vec3& t,
                      const glm::vec3& weights) {
    return weights.x * glm::vec3(attribute[t[0]]) + weights.y * glm::vec3(attribute[t[1]]) +
           weights.z * glm::vec3(attribute[t[2]]);
}

void store(glm::u8vec3 colour, uint8_t* rgb) {
    for (int k = 0; k < 3; ++k) rgb[k] = colour[k];
}

struct Shader {
    glm::mat3 view_from_world;
    Look look;
    Shade mode;
    bool levels;  // grey, whatever colours the mesh has
    Light light;

    Shader(const geom::View& view, const Look& of)
        : view_from_world(glm::transpose(glm::dmat3(view.right, view.down, view.forward))),
          look(of),
          mode(of.shade == Shade::level ? Shade::lit : of.shade),
          levels(of.shade == Shade::level),
          light(light_of(of, view)) {}

    glm::u8vec3 shade(const glm::vec3& world_normal, const glm::vec3& material) const {
        const float length = glm::length(world_normal);
        const glm::vec3 normal = length > 0 ? view_from_world * world_normal / length : glm::vec3(0);
        return shade_point(mode, normal, material, light);
    }
};

// The triangles of one piece that may cover a pixel, sorted by tile, in the mesh's order within a tile.
struct Piece {
    struct Entry {
        uint32_t tile, triangle;
    };
    std::vector<Entry> entries;
    std::vector<uint32_t> begin;  // of each tile in `triangles`, and the end
    std::vector<uint32_t> triangles;

    void sort(size_t tile_count) {
        begin.assign(tile_count + 1, 0);
        for (const Entry& e : entries) ++begin[e.tile + 1];
        for (size_t t = 0; t < tile_count; ++t) begin[t + 1] += begin[t];
        triangles.resize(entries.size());
        for (const Entry& e : entries) triangles[begin[e.tile]++] = e.triangle;
        for (size_t t = tile_count; t > 0; --t) begin[t] = begin[t - 1];
        begin[0] = 0;
    }
};

}  // namespace

std::vector<glm::vec3> filled_normals(const mesh::Mesh& mesh) {
    std::vector<glm::vec3> normals = area_weighted_normals(mesh);
    for (size_t v = 0; v < mesh.normals.size(); ++v) {
        if (mesh.normals[v] != glm::vec3(0)) normals[v] = mesh.normals[v];
    }
    return normals;
}

struct MeshRaster::State {
    const mesh::Mesh& mesh;
    std::vector<glm::vec3> own_normals;  // empty where the mesh's will do
    double largest_coordinate = 0;
    std::vector<Ray> rays;    // of the vertices
    std::vector<Span> spans;  // likewise
    std::vector<Piece> pieces;

    explicit State(const mesh::Mesh& m) : mesh(m) {
        if (mesh.is_cloud()) return;
        if (has_unknown_normal(mesh)) own_normals = filled_normals(mesh);
        for (const glm::vec3& p : mesh.positions) {
            largest_coordinate =
                std::max(largest_coordinate, double(std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)})));
        }
    }

    const std::vector<glm::vec3>& normals() const { return own_normals.empty() ? mesh.normals : own_normals; }

    // A power of two (so that it rounds nothing) that brings the scene near 1, where products of three
    // coordinates neither overflow nor vanish.
    double frame_scale(const geom::View& view) const {
        const glm::dvec3 d = glm::abs(mesh.origin - view.eye);
        const double reach = std::max({d.x, d.y, d.z}) + largest_coordinate;
        return reach > 0 && std::isfinite(reach) ? std::ldexp(1.0, -std::ilogb(reach)) : 1.0;
    }

    void transform(const Raster& raster, const geom::View& view, double scale) {
        rays.resize(mesh.positions.size());
        spans.resize(rays.size());
        core::parallel_pieces(rays.size(), kVertexGrain, [&](size_t begin, size_t end) {
            for (size_t v = begin; v < end; ++v) {
                const glm::dvec3 p = view.view_from_world(mesh.world(v)) * scale;
                rays[v] = {view.focal_px * p.x, view.focal_px * p.y, p.z};
                spans[v] = span_of(raster, rays[v]);
            }
        });
    }

    // The pixels that a triangle may cover.
    PixelBox box_of(const Raster& raster, const glm::u32vec3& t) const {
        const Span all = least(least(spans[t[0]], spans[t[1]]), spans[t[2]]);
        if (all.first_x == kBehind) return box_across_eye(raster, rays[t[0]], rays[t[1]], rays[t[2]]);
        return {all.first_x, all.first_y, ~all.not_last_x, ~all.not_last_y};
    }

    void sort_into_tiles(const Raster& raster) {
        const size_t count = mesh.triangles.size();
        const size_t piece_count = std::clamp(count / kLeastPiece, size_t(1), kMostPieces);
        pieces.resize(piece_count);
        core::parallel_for(piece_count, [&](size_t p) {
            Piece& piece = pieces[p];
            piece.entries.clear();
            const size_t end = count * (p + 1) / piece_count;
            for (size_t t = count * p / piece_count; t < end; ++t) add_triangle(raster, uint32_t(t), piece);
            piece.sort(size_t(raster.tiles_x) * size_t(raster.tiles_y));
        });
    }

    void add_triangle(const Raster& raster, uint32_t index, Piece& piece) const {
        const glm::u32vec3 t = mesh.triangles[index];
        const PixelBox box = box_of(raster, t);
        if (box.empty()) return;
        const int tx0 = box.first_x / kTile, tx1 = box.last_x / kTile;
        const int ty0 = box.first_y / kTile, ty1 = box.last_y / kTile;
        if (tx0 == tx1 && ty0 == ty1) {
            piece.entries.push_back({uint32_t(ty0 * raster.tiles_x + tx0), index});
            return;
        }
        TriangleSetup setup;
        if (!setup.set(raster, rays[t[0]], rays[t[1]], rays[t[2]])) return;
        for (int ty = ty0; ty <= ty1; ++ty) {
            for (int tx = tx0; tx <= tx1; ++tx) {
                if (!setup.may_touch(raster, intersect(box, raster.tile(tx, ty)))) continue;
                piece.entries.push_back({uint32_t(ty * raster.tiles_x + tx), index});
            }
        }
    }

    void draw_tile(const Raster& raster, size_t tile_index, TileBuffer& out) const {
        const PixelBox tile = raster.tile(int(tile_index) % raster.tiles_x, int(tile_index) / raster.tiles_x);
        for (const Piece& piece : pieces) {
            const uint32_t end = piece.begin[tile_index + 1];
            for (uint32_t e = piece.begin[tile_index]; e < end; ++e) {
                const uint32_t index = piece.triangles[e];
                if (e + kPrefetch < end) prefetch(piece.triangles[e + kPrefetch]);
                const glm::u32vec3 t = mesh.triangles[index];
                TriangleSetup setup;
                if (!setup.set(raster, rays[t[0]], rays[t[1]], rays[t[2]])) continue;
                draw_triangle(raster, setup, intersect(box_of(raster, t), tile), tile, index, out);
            }
        }
    }

    void prefetch(uint32_t triangle) const {
        const glm::u32vec3 t = mesh.triangles[triangle];
        for (int k = 0; k < 3; ++k) __builtin_prefetch(&rays[t[k]]), __builtin_prefetch(&spans[t[k]]);
    }

    // The tile's pixels, of across x across samples each.
    void shade_tile(const Raster& raster, size_t tile_index, const TileBuffer& drawn, const Shader& shader,
                    double scale, Frame& frame) const {
        const PixelBox tile = raster.tile(int(tile_index) % raster.tiles_x, int(tile_index) / raster.tiles_x);
        const int across = shader.look.samples_across;
        for (int j = tile.first_y; j <= tile.last_y; j += across) {
            for (int i = tile.first_x; i <= tile.last_x; i += across) {
                const int at = (j - tile.first_y) * kTile + (i - tile.first_x);
                const size_t pixel = size_t(j / across) * size_t(frame.width) + size_t(i / across);
                const MixedPixel mixed = shade_pixel(drawn, at, shader);
                store(mixed.rgb, &frame.rgb[3 * pixel]);
                if (!frame.alpha.empty()) frame.alpha[pixel] = mixed.alpha;
                const double z = drawn.z[at + shader.look.depth_sample() * (kTile + 1)];
                constexpr double kMost = std::numeric_limits<float>::max();
                if (std::isfinite(z)) frame.depth[pixel] = float(std::min(z / scale, kMost));
            }
        }
    }

    // The pixel whose first sample is `first`.
    MixedPixel shade_pixel(const TileBuffer& drawn, int first, const Shader& shader) const {
        const int across = shader.look.samples_across;
        PixelSamples samples{.count = uint32_t(across * across)};
        for (int y = 0; y < across; ++y) {
            for (int x = 0; x < across; ++x) {
                const int at = first + y * kTile + x;
                if (drawn.z[at] == std::numeric_limits<double>::infinity()) continue;
                const glm::u32vec3 t = mesh.triangles[drawn.triangle[at]];
                const glm::vec3 weights{1 - drawn.weight_b[at] - drawn.weight_c[at], drawn.weight_b[at],
                                        drawn.weight_c[at]};
                samples.core_sum += glm::u32vec3(
                    shader.shade(interpolate(normals(), t, weights), material(t, weights, shader.levels)));
                ++samples.cores;
            }
        }
        return mix(samples, shader.look);
    }

    glm::vec3 material(const glm::u32vec3& t, const glm::vec3& weights, bool grey) const {
        return grey || mesh.colours.empty() ? glm::vec3(kGreyMaterial)
                                            : interpolate(mesh.colours, t, weights);
    }
};

MeshRaster::MeshRaster(const mesh::Mesh& mesh) : state_(std::make_unique<State>(mesh)) {}

MeshRaster::~MeshRaster() = default;

void MeshRaster::draw(const geom::View& view, const Look& look, Frame& frame) {
    frame.resize(view.width, view.height);
    if (look.has_alpha()) frame.alpha.resize(frame.depth.size());
    frame.depth_at = look.depth_at();
    const geom::View samples = subdivided(view, look.samples_across);
    const double scale = state_->frame_scale(samples);
    const Raster raster(samples, scale);
    const Shader shader(view, look);
    state_->transform(raster, samples, scale);
    state_->sort_into_tiles(raster);
    core::parallel_for(size_t(raster.tiles_x) * size_t(raster.tiles_y), [&](size_t tile) {
        TileBuffer drawn;
        state_->draw_tile(raster, tile, drawn);
        state_->shade_tile(raster, tile, drawn, shader, scale, frame);
    });
}

}  // namespace render
