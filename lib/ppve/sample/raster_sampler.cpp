#include "ppve/sample/raster_sampler.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/parallel.h"
#include "core/stopwatch.h"
#include "ppve/sample/depth_pyramid.h"
#include "ppve/sample/depth_words.h"
#include "ppve/sample/raster_vertices.h"
#include "render/exact_triangle.h"

namespace ppve {

namespace {

constexpr size_t kWaves = 12;      // between which the pyramid is made
constexpr size_t kLeastWave = 64;  // clusters
constexpr size_t kGrain = 4;       // clusters handed to a thread at a time
// Shares of a triangle's corners are right within the inverse of it, or are left to exact arithmetic.
constexpr double kSliver = 0x1p20;
constexpr int kRowsAtOnce = 16;  // of what is done row by row

// One frustum as triangles are drawn into it.
struct Scene {
    RasterFrame frame;
    render::Raster raster;  // the same for exact arithmetic
    DepthKeys keys;
    geom::View view;
    double nearest, farthest;  // near and far, or depths beyond all; times scale

    Scene(const DepthImage& image, const Clusters& clusters, double scale)
        : frame{}, raster(image.frustum.view, scale), keys(image.coding, scale), view(image.frustum.view) {
        frame.perspective = image.frustum.projection == Projection::perspective;
        const glm::dvec3 axes[3] = {view.right, view.down, view.forward};
        for (int k = 0; k < 3; ++k) {
            frame.offset[k] = clusters.origin()[k], frame.eye[k] = view.eye[k];
            for (int c = 0; c < 3; ++c) frame.axes[k][c] = axes[k][c];
        }
        frame.scale = scale;
        // An orthographic place is focal_px * x itself.
        frame.focal_px = frame.perspective ? view.focal_px : view.focal_px / scale;
        frame.corner_x = raster.side_x(-1), frame.corner_y = raster.side_y(-1);
        frame.width = view.width, frame.height = view.height;
        frame.slack = raster.slack;
        nearest = view.near           ? *view.near * scale
                  : frame.perspective ? 0
                                      : -std::numeric_limits<double>::infinity();
        farthest = view.far ? *view.far * scale : std::numeric_limits<double>::infinity();
    }

    // A vertex as exact arithmetic takes it: render::ray_of(); orthographic rays are (x, y, 1) at one depth.
    render::Ray ray(const ClusterView& c, uint16_t v) const {
        const glm::dvec3 world = glm::dvec3(frame.offset[0], frame.offset[1], frame.offset[2]) +
                                 glm::dvec3(c.x[v], c.y[v], c.z[v]);
        const glm::dvec3 p = view.view_from_world(world) * frame.scale;
        return {frame.focal_px * p.x, frame.focal_px * p.y, frame.perspective ? p.z : 1};
    }
};

// A cluster that the frustum meets.
struct Visible {
    double depth;  // of its box's nearest corner, times scale
    uint32_t cluster;
    render::PixelBox box;  // of pixels that it may cover
    uint64_t nearest;      // no sample has a larger word
    bool operator<(const Visible& o) const {
        return depth != o.depth ? depth < o.depth : cluster < o.cluster;
    }
};

struct Corner {
    double x, y, w;
};

enum class Pass { words, normals };

// Draws the triangles of one cluster.  Words: the nearest stay.  Normals: of the words that stayed.
template <bool kPerspective, Pass kPass>
class Drawing {
  public:
    Drawing(const Scene& scene, const ClusterView& cluster, const uint32_t* colours,
            std::vector<uint64_t>& words, std::vector<uint16_t>& normals)
        : scene_(scene), cluster_(cluster), colours_(colours), words_(words), normals_(normals) {}

    void draw(const RasterVertices& at, uint32_t triangle) {
        corners_ = cluster_.corners + 3 * size_t(triangle);
        constexpr render::PixelBox kNone{0, 0, -1, -1};
        render::PixelBox box = kNone;
        if (!find_box(at, box)) return draw_exactly();
        const auto corner = [&](int k) {
            return Corner{at.x[corners_[k]], at.y[corners_[k]], at.w[corners_[k]]};
        };
        const Corner a = corner(0), b = corner(1), c = corner(2);
        const double abx = b.x - a.x, aby = b.y - a.y, acx = c.x - a.x, acy = c.y - a.y;
        const double area = abx * acy - aby * acx;
        const double extent = std::max({std::abs(abx), std::abs(aby), std::abs(acx), std::abs(acy)}) + 1;
        // Places are off by two roundings of 2^-53 of their size; an edge's value by that times the lengths
        // in it, which for pixels of the box are no more than the extent, and by as much again for each of
        // its operations.
        const double doubt = 0x1p-46 * (std::abs(a.x) + std::abs(a.y) + extent) * extent;
        if (!(std::abs(area) > kSliver * doubt)) return draw_exactly();
        const double sign = area > 0 ? 1 : -1;
        const double bcx = (c.x - b.x) * sign, bcy = (c.y - b.y) * sign, cax = -acx * sign, cay = -acy * sign;
        const double inverse_area = 1 / std::abs(area);
        for (int j = box.first_y; j <= box.last_y; ++j) {
            const double y = scene_.raster.centre_y(j);
            for (int i = box.first_x; i <= box.last_x; ++i) {
                const double x = scene_.raster.centre_x(i);
                const double va = bcx * (y - b.y) - bcy * (x - b.x), vb = cax * (y - c.y) - cay * (x - c.x);
                const double vc = std::abs(area) - va - vb;
                const double least = std::min(std::min(va, vb), vc);
                if (least < -doubt) continue;
                if (!(least > doubt)) return draw_exactly();
                put(i, j, va * inverse_area, vb * inverse_area, vc * inverse_area, a.w, b.w, c.w);
            }
        }
    }

  private:
    // False where a corner has no place.
    bool find_box(const RasterVertices& at, render::PixelBox& box) const {
        int16_t least[4];
        for (int k = 0; k < 3; ++k) {
            const PackedSpan span = at.span[corners_[k]];
            for (int n = 0; n < 4; ++n) {
                const int16_t value = int16_t(span >> 16 * n);
                least[n] = k == 0 ? value : std::min(least[n], value);
            }
        }
        if (least[0] == kNowhere) return false;
        box = {least[0], least[1], ~least[2], ~least[3]};
        return true;
    }

    // By the exact arithmetic of render::MeshRaster, whatever the triangle.
    [[gnu::noinline]] void draw_exactly() {
        render::Ray rays[3];
        double w[3];
        for (int k = 0; k < 3; ++k) {
            rays[k] = scene_.ray(cluster_, corners_[k]);
            w[k] = kPerspective ? 0 : depth_of(corners_[k]);
        }
        const auto span = [&](int k) { return render::span_of(scene_.raster, rays[k]); };
        const render::Span all = render::least(render::least(span(0), span(1)), span(2));
        const render::PixelBox box = render::intersect(
            render::box_of(scene_.raster, all, rays[0], rays[1], rays[2]), scene_.raster.all());
        render::TriangleSetup setup;
        if (box.empty() || !setup.set(scene_.raster, rays[0], rays[1], rays[2])) return;
        for (int j = box.first_y; j <= box.last_y; ++j)
            for (int i = box.first_x; i <= box.last_x; ++i) {
                render::TriangleSetup::Meeting met;
                if (!setup.meets(scene_.raster.centre_x(i), scene_.raster.centre_y(j), met)) continue;
                const double weight_a = 1 - met.weight_b - met.weight_c;
                const double z =
                    kPerspective ? met.z : weight_a * w[0] + met.weight_b * w[1] + met.weight_c * w[2];
                if (!(z >= scene_.nearest) || z > scene_.farthest || (kPerspective && !(z > 0))) continue;
                put_colour(i, j, kPerspective ? scene_.keys.of_inverse(1 / z) : scene_.keys.of_depth(z),
                           weight_a, met.weight_b, met.weight_c);
            }
    }

    double depth_of(uint16_t v) const {
        const glm::dvec3 world =
            glm::dvec3(scene_.frame.offset[0], scene_.frame.offset[1], scene_.frame.offset[2]) +
            glm::dvec3(cluster_.x[v], cluster_.y[v], cluster_.z[v]);
        return scene_.view.view_from_world(world).z * scene_.frame.scale;
    }

    // Shares of the corners on the raster, and w there.
    void put(int i, int j, double sa, double sb, double sc, double wa, double wb, double wc) {
        const double pa = sa * wa, pb = sb * wb, pc = sc * wc;
        // Between the corners', whatever is rounded: a sliver's shares are worth nothing.
        const double w =
            std::clamp(pa + pb + pc, std::min(std::min(wa, wb), wc), std::max(std::max(wa, wb), wc));
        if constexpr (kPerspective) {
            if (w * scene_.nearest > 1 || w * scene_.farthest < 1) return;
            const uint64_t key = scene_.keys.of_inverse(w);
            if (is_behind(i, j, key)) return;
            const double inverse = 1 / (pa + pb + pc);
            put_colour(i, j, key, pa * inverse, pb * inverse, pc * inverse);
        } else {
            if (!(w >= scene_.nearest) || w > scene_.farthest) return;
            const uint64_t key = scene_.keys.of_depth(w);
            if (is_behind(i, j, key)) return;
            put_colour(i, j, key, sa, sb, sc);
        }
    }

    size_t pixel(int i, int j) const { return size_t(j) * size_t(scene_.frame.width) + size_t(i); }

    bool is_behind(int i, int j, uint64_t key) const {
        const std::atomic_ref<uint64_t> at(words_[pixel(i, j)]);
        return word_of(key, 0xffffff) < at.load(std::memory_order_relaxed);
    }

    void put_colour(int i, int j, uint64_t key, double a, double b, double c) {
        const uint64_t word = word_of(key, mixed_colour(float(a), float(b), float(c)));
        if constexpr (kPass == Pass::words) {
            raise(words_[pixel(i, j)], word);
        } else if (words_[pixel(i, j)] == word) {
            raise(normals_[pixel(i, j)], mixed_normal(float(a), float(b), float(c)));
        }
    }

    uint32_t mixed_colour(float a, float b, float c) const {
        const uint32_t ca = colours_[corners_[0]], cb = colours_[corners_[1]], cc = colours_[corners_[2]];
        uint32_t mixed = 0;
        for (int shift = 0; shift < 24; shift += 8) {
            const auto channel = [&](uint32_t colour) { return float(int32_t(colour >> shift & 0xff)); };
            const float value = a * channel(ca) + b * channel(cb) + c * channel(cc) + 0.5f;
            mixed |= uint32_t(int32_t(std::clamp(value, 0.0f, 255.0f))) << shift;
        }
        return mixed;
    }

    uint16_t mixed_normal(float a, float b, float c) const {
        const auto normal = [&](int k) { return octahedral_normal(cluster_.normal[corners_[k]]); };
        return octahedral_code(a * normal(0) + b * normal(1) + c * normal(2));
    }

    const Scene& scene_;
    const ClusterView& cluster_;
    const uint32_t* colours_;
    std::vector<uint64_t>& words_;
    std::vector<uint16_t>& normals_;
    const uint16_t* corners_ = nullptr;
};

struct Tested {
    uint64_t triangles = 0, drawn = 0;
};

template <Pass kPass>
Tested draw_cluster(const Scene& scene, const ClusterView& cluster, const uint32_t* colours,
                    std::vector<uint64_t>& words, std::vector<uint16_t>& normals) {
    thread_local RasterVertices vertices;
    thread_local std::array<uint16_t, kClusterTriangles> drawable;
    place_vertices(scene.frame, cluster, vertices);
    const size_t count = find_drawable(cluster, vertices, drawable.data());
    const auto draw = [&](auto&& drawing) {
        for (size_t n = 0; n < count; ++n) drawing.draw(vertices, drawable[n]);
    };
    if (scene.frame.perspective)
        draw(Drawing<true, kPass>(scene, cluster, colours, words, normals));
    else
        draw(Drawing<false, kPass>(scene, cluster, colours, words, normals));
    return {cluster.triangles, count};
}

}  // namespace

struct RasterSampler::State {
    Clusters clusters;
    double largest_coordinate = 0;
    std::vector<uint64_t> words;
    std::vector<Visible> visible;
    std::vector<uint8_t> is_hidden;  // by place in `visible`
    DepthPyramid pyramid;

    explicit State(Clusters c) : clusters(std::move(c)) {
        for (const Clusters::Entry& e : clusters.entries())
            for (int k = 0; k < 3; ++k)
                largest_coordinate =
                    std::max({largest_coordinate, std::abs(double(e.low[k])), std::abs(double(e.high[k]))});
    }

    // As in render::MeshRaster: a power of two that brings the scene near 1.
    double scale_of(const geom::View& view) const {
        const glm::dvec3 d = glm::abs(clusters.origin() - view.eye);
        const double reach = std::max({d.x, d.y, d.z}) + largest_coordinate;
        return reach > 0 && std::isfinite(reach) ? std::ldexp(1.0, -std::ilogb(reach)) : 1.0;
    }

    void find_visible(const Scene& scene);
    void draw(const Scene& scene, bool material, SampleCounts& counts);
    void draw_normals(const Scene& scene, DepthImage& image);
    void resolve(const Scene& scene, DepthImage& image);
};

namespace {

// The pixels that a cluster may cover and its nearest depth, by its box's corners; false: outside the
// frustum.
bool look_at(const Scene& scene, const Clusters::Entry& e, Visible& out) {
    render::Span all{};
    render::Ray rays[8];
    double nearest = std::numeric_limits<double>::infinity(), farthest = -nearest;
    double reach = 0;
    for (int corner = 0; corner < 8; ++corner) {
        glm::dvec3 world;
        for (int k = 0; k < 3; ++k)
            world[k] = scene.frame.offset[k] + double(corner >> k & 1 ? e.high[k] : e.low[k]);
        const glm::dvec3 p = scene.view.view_from_world(world) * scene.frame.scale;
        nearest = std::min(nearest, p.z), farthest = std::max(farthest, p.z);
        reach = std::max({reach, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
        rays[corner] = {scene.frame.focal_px * p.x, scene.frame.focal_px * p.y,
                        scene.frame.perspective ? p.z : 1};
        const render::Span span = render::span_of(scene.raster, rays[corner]);
        all = corner == 0 ? span : render::least(all, span);
    }
    // Vertices inside the box are rounded on the way as its corners are.
    const double rounding = reach * 0x1p-45;
    if (nearest - rounding > scene.farthest || farthest + rounding < scene.nearest) return false;
    if (scene.frame.perspective && !(farthest > -rounding)) return false;
    out.box = scene.raster.all();
    if (all.first_x == render::kBehind) {
        // A box that reaches behind the eye: outside only where one side of the pyramid has all its corners
        // outside.
        for (const double sign : {-1.0, 1.0}) {
            const double w = scene.raster.side_x(sign), h = scene.raster.side_y(sign);
            if (std::all_of(rays, rays + 8,
                            [&](const render::Ray& r) { return render::beyond(r.x, r.z, w, sign); }))
                return false;
            if (std::all_of(rays, rays + 8,
                            [&](const render::Ray& r) { return render::beyond(r.y, r.z, h, sign); }))
                return false;
        }
        out.depth = 0, out.nearest = ~uint64_t(0);
        return true;
    }
    out.box = {std::max(all.first_x - 1, 0), std::max(all.first_y - 1, 0),
               std::min(~all.not_last_x + 1, scene.frame.width - 1),
               std::min(~all.not_last_y + 1, scene.frame.height - 1)};
    if (out.box.empty()) return false;
    out.depth = nearest;
    const double bound = nearest - rounding;
    out.nearest = !scene.frame.perspective ? word_of(scene.keys.of_depth(bound), 0xffffff)
                  : bound > 0              ? word_of(scene.keys.of_inverse(1 / bound), 0xffffff)
                                           : ~uint64_t(0);
    return true;
}

}  // namespace

void RasterSampler::State::find_visible(const Scene& scene) {
    const auto entries = clusters.entries();
    std::vector<Visible> all(entries.size());
    core::parallel_for(
        entries.size(),
        [&](size_t c) {
            all[c].cluster = uint32_t(c);
            if (!look_at(scene, entries[c], all[c])) all[c].box = {0, 0, -1, -1};
        },
        256);
    visible.clear();
    std::copy_if(all.begin(), all.end(), std::back_inserter(visible),
                 [](const Visible& v) { return !v.box.empty(); });
    std::sort(visible.begin(), visible.end());
    is_hidden.assign(visible.size(), 0);
}

void RasterSampler::State::draw(const Scene& scene, bool material, SampleCounts& counts) {
    const size_t wave = std::max(kLeastWave, (visible.size() + kWaves - 1) / kWaves);
    std::atomic<uint64_t> tested{0}, drawn{0}, touched{0}, bytes{0}, hidden{0};
    std::vector<uint16_t> no_normals;
    for (size_t begin = 0; begin < visible.size(); begin += wave) {
        if (begin > 0) pyramid.update(words);
        core::parallel_for(
            std::min(wave, visible.size() - begin),
            [&](size_t n) {
                const Visible& v = visible[begin + n];
                if (pyramid.hides(v.box, v.nearest)) {
                    is_hidden[begin + n] = 1;
                    hidden.fetch_add(1, std::memory_order_relaxed);
                    return;
                }
                const ClusterView cluster = clusters.view(v.cluster);
                const Tested t = draw_cluster<Pass::words>(
                    scene, cluster, material ? cluster.material : cluster.lit, words, no_normals);
                tested.fetch_add(t.triangles, std::memory_order_relaxed),
                    drawn.fetch_add(t.drawn, std::memory_order_relaxed);
                touched.fetch_add(1, std::memory_order_relaxed);
                bytes.fetch_add(clusters.bytes_of(v.cluster), std::memory_order_relaxed);
            },
            kGrain);
    }
    counts.triangles_tested = tested, counts.triangles_drawn = drawn, counts.clusters_touched = touched;
    counts.clusters_hidden = hidden, counts.bytes_touched = bytes;
}

void RasterSampler::State::draw_normals(const Scene& scene, DepthImage& image) {
    core::parallel_for(
        visible.size(),
        [&](size_t n) {
            if (is_hidden[n]) return;
            const ClusterView cluster = clusters.view(visible[n].cluster);
            draw_cluster<Pass::normals>(scene, cluster, cluster.material, words, image.normal);
        },
        kGrain);
}

void RasterSampler::State::resolve(const Scene& scene, DepthImage& image) {
    core::parallel_pieces(words.size(), size_t(scene.frame.width) * kRowsAtOnce,
                          [&](size_t begin, size_t end) {
                              for (size_t p = begin; p < end; ++p) {
                                  const uint64_t key = words[p] >> 24;
                                  image.depth[p] = key == 0 ? 0 : scene.keys.code(key);
                                  image.colour[p] = uint32_t(words[p] & 0xffffff);
                              }
                          });
}

RasterSampler::RasterSampler(Clusters clusters) : state_(std::make_unique<State>(std::move(clusters))) {}

RasterSampler::~RasterSampler() = default;

Box RasterSampler::bounds() const {
    return state_->clusters.bounds();
}

SampleCounts RasterSampler::sample(DepthImage& image, bool with_normals) {
    core::Stopwatch watch;
    State& s = *state_;
    image.clear(with_normals);
    SampleCounts counts;
    counts.bytes = s.clusters.bytes(), counts.clusters = s.clusters.entries().size();
    const Scene scene(image, s.clusters, s.scale_of(image.frustum.view));
    s.words.assign(image.pixels(), 0);
    s.pyramid.clear(image.width(), image.height());
    s.find_visible(scene);
    s.draw(scene, with_normals, counts);
    if (with_normals) s.draw_normals(scene, image);
    s.resolve(scene, image);
    counts.ms = watch.lap_ms();
    return counts;
}

}  // namespace ppve
