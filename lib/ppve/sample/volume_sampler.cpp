#include "ppve/sample/volume_sampler.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <optional>
#include <vector>

#include "core/parallel.h"
#include "core/stopwatch.h"
#include "ppve/sample/light.h"
#include "ppve/sample/pixel_rays.h"
#include "render/shading.h"

namespace ppve {

namespace {

constexpr int kBrick = 8;        // cells a side
constexpr int kBisections = 60;  // as many as a double has bits, and some

// Values at a cell's corners, less iso: x fastest.
using Cell = std::array<double, 8>;

double trilinear(const Cell& c, const glm::dvec3& p) {
    const auto mix = [](double a, double b, double t) { return a + (b - a) * t; };
    const double near = mix(mix(c[0], c[1], p.x), mix(c[2], c[3], p.x), p.y);
    return mix(near, mix(mix(c[4], c[5], p.x), mix(c[6], c[7], p.x), p.y), p.z);
}

glm::dvec3 gradient(const Cell& c, const glm::dvec3& p) {
    const auto side = [&](int axis, double at) {
        glm::dvec3 q = p;
        q[axis] = at;
        return trilinear(c, q);
    };
    return {side(0, 1) - side(0, 0), side(1, 1) - side(1, 0), side(2, 1) - side(2, 0)};
}

// Where in (0, 1) the cubic through f(0), f(1/3), f(2/3), f(1) turns, in order.
struct Turns {
    std::array<double, 2> at{};
    int count = 0;
};
Turns turns_of(double f0, double f1, double f2, double f3) {
    const double a = 4.5 * (f3 - f0) + 13.5 * (f1 - f2);
    const double b = 9 * f0 - 22.5 * f1 + 18 * f2 - 4.5 * f3;
    const double c = -5.5 * f0 + 9 * f1 - 4.5 * f2 + f3;
    // 3 a t^2 + 2 b t + c = 0, without loss where a is small.
    const double disc = b * b - 3 * a * c;
    Turns turns;
    if (!(disc > 0)) return turns;
    const double q = -(b + std::copysign(std::sqrt(disc), b));
    for (const double t : {q / (3 * a), c / q})
        if (t > 0 && t < 1) turns.at[size_t(turns.count++)] = t;
    if (turns.count == 2 && turns.at[0] > turns.at[1]) std::swap(turns.at[0], turns.at[1]);
    return turns;
}

}  // namespace

struct VolumeSampler::State {
    Volume volume;
    double iso;
    glm::ivec3 bricks;
    struct Range {
        float low, high;
    };
    std::vector<Range> ranges;  // of each brick's values
    std::vector<std::atomic<uint8_t>> touched;

    State(Volume v, double at)
        : volume(std::move(v)),
          iso(at),
          bricks((volume.header().size - 1 + kBrick - 1) / kBrick),
          ranges(size_t(bricks.x) * size_t(bricks.y) * size_t(bricks.z)),
          touched(ranges.size()) {
        core::parallel_for(ranges.size(), [&](size_t b) { ranges[b] = range_of(b); });
    }

    size_t brick(const glm::ivec3& b) const {
        return (size_t(b.z) * size_t(bricks.y) + size_t(b.y)) * size_t(bricks.x) + size_t(b.x);
    }
    bool has_surface(size_t b) const { return double(ranges[b].low) <= iso && double(ranges[b].high) >= iso; }

    Range range_of(size_t b) const {
        const glm::ivec3 at(int(b % size_t(bricks.x)), int(b / size_t(bricks.x) % size_t(bricks.y)),
                            int(b / (size_t(bricks.x) * size_t(bricks.y))));
        const glm::ivec3 first = at * kBrick, last = glm::min(first + kBrick, volume.header().size - 1);
        Range r{volume.at(first.x, first.y, first.z), volume.at(first.x, first.y, first.z)};
        for (int z = first.z; z <= last.z; ++z)
            for (int y = first.y; y <= last.y; ++y)
                for (int x = first.x; x <= last.x; ++x) {
                    const float value = volume.at(x, y, z);
                    r.low = std::min(r.low, value), r.high = std::max(r.high, value);
                }
        return r;
    }

    Cell cell(const glm::ivec3& at) const {
        Cell c;
        for (int k = 0; k < 8; ++k)
            c[size_t(k)] = double(volume.at(at.x + (k & 1), at.y + (k >> 1 & 1), at.z + (k >> 2))) - iso;
        return c;
    }

    struct Hit {
        double depth;
        glm::dvec3 gradient;  // world
    };
    std::optional<Hit> cast(const PixelRay& grid_ray, const DepthInterval& inside);
    std::optional<double> root(const Cell& c, const glm::ivec3& at, const PixelRay& ray, double first,
                               double last, int& sign) const;
};

namespace {

// Steps through boxes of `step` cells a side that a ray meets, in order.  `ray` is in cells.
class Steps {
  public:
    Steps(const PixelRay& ray, double from, double to, int step, const glm::ivec3& low,
          const glm::ivec3& high)
        : ray_(ray), step_(step), from_(from), to_(to), low_(low), high_(high) {
        const glm::dvec3 p = ray.origin + ray.direction * from;
        for (int k = 0; k < 3; ++k)
            at_[k] = int(std::clamp(std::floor(p[k] / step), double(low[k]), double(high[k])));
    }
    const glm::ivec3& at() const { return at_; }
    double from() const { return from_; }
    // Where the ray leaves the box; finds where to go from there.
    double leave() {
        double best = to_;
        axis_ = -1;
        for (int k = 0; k < 3; ++k) {
            if (ray_.direction[k] == 0) continue;
            const double side = double(ray_.direction[k] > 0 ? at_[k] + 1 : at_[k]) * step_;
            const double t = (side - ray_.origin[k]) / ray_.direction[k];
            if (t < best) best = t, axis_ = k;
        }
        return std::max(best, from_);
    }
    // False: the ray has ended, or left the boxes.
    bool go_on(double left) {
        if (axis_ < 0) return false;
        from_ = left;
        at_[axis_] += ray_.direction[axis_] > 0 ? 1 : -1;
        return at_[axis_] >= low_[axis_] && at_[axis_] <= high_[axis_];
    }

  private:
    const PixelRay& ray_;
    int step_, axis_ = -1;
    double from_, to_;
    glm::ivec3 at_{0}, low_, high_;
};

}  // namespace

// The first root between two depths within a cell.  `sign`: of the volume where the ray has come from, 0 at
// first; kept, so that a surface on the side of two cells is not lost by what each rounds.
std::optional<double> VolumeSampler::State::root(const Cell& c, const glm::ivec3& at, const PixelRay& ray,
                                                 double first, double last, int& sign) const {
    const auto value = [&](double t) {
        const double depth = first + (last - first) * t;
        return trilinear(c, glm::clamp(ray.origin + ray.direction * depth - glm::dvec3(at), 0.0, 1.0));
    };
    const double f0 = value(0), f3 = value(1);
    const int now = f0 < 0 ? -1 : 1;
    if (sign != 0 && now != sign) return first;
    const Turns turns = turns_of(f0, value(1.0 / 3), value(2.0 / 3), f3);
    double low = 0;
    for (int n = 0; n <= turns.count; ++n) {
        double high = n < turns.count ? turns.at[size_t(n)] : 1;
        if ((value(high) < 0 ? -1 : 1) == now) {
            low = high;
            continue;
        }
        for (int k = 0; k < kBisections; ++k) {
            const double middle = 0.5 * (low + high);
            ((value(middle) < 0 ? -1 : 1) == now ? low : high) = middle;
        }
        return first + (last - first) * high;
    }
    sign = now;
    return std::nullopt;
}

std::optional<VolumeSampler::State::Hit> VolumeSampler::State::cast(const PixelRay& ray,
                                                                    const DepthInterval& inside) {
    int sign = 0;
    Steps outer(ray, inside.first, inside.last, kBrick, {0, 0, 0}, bricks - 1);
    do {
        const size_t b = brick(outer.at());
        const double end = outer.leave();
        if (has_surface(b)) {
            touched[b].store(1, std::memory_order_relaxed);
            const glm::ivec3 low = outer.at() * kBrick,
                             high = glm::min(low + kBrick - 1, volume.header().size - 2);
            Steps inner(ray, outer.from(), end, 1, low, high);
            do {
                const double leave = inner.leave();
                const Cell c = cell(inner.at());
                if (const auto depth = root(c, inner.at(), ray, inner.from(), leave, sign)) {
                    const glm::dvec3 p =
                        glm::clamp(ray.origin + ray.direction * *depth - glm::dvec3(inner.at()), 0.0, 1.0);
                    return Hit{*depth, gradient(c, p) / volume.header().spacing};
                }
                if (!inner.go_on(leave)) break;
            } while (true);
        } else {
            sign = double(ranges[b].high) < iso ? -1 : 1;
        }
        if (!outer.go_on(end)) return std::nullopt;
    } while (true);
}

VolumeSampler::VolumeSampler(Volume volume, double iso)
    : state_(std::make_unique<State>(std::move(volume), iso)) {}

VolumeSampler::~VolumeSampler() = default;

Box VolumeSampler::bounds() const {
    const VolumeHeader& h = state_->volume.header();
    Box box;
    box.add(h.offset), box.add(h.offset + h.spacing * glm::dvec3(h.size - 1));
    return box;
}

SampleCounts VolumeSampler::sample(DepthImage& image, bool with_normals) {
    core::Stopwatch watch;
    State& s = *state_;
    const VolumeHeader& h = s.volume.header();
    image.clear(with_normals);
    for (auto& t : s.touched) t.store(0, std::memory_order_relaxed);
    const DepthRange range = depths_in(image.frustum, bounds());
    core::parallel_for(range.is_empty ? 0 : size_t(image.height()), [&](size_t j) {
        for (int i = 0; i < image.width(); ++i) {
            // In cells: sample (x, y, z) is at (x, y, z).
            PixelRay ray = pixel_ray(image.frustum, i, int(j));
            ray.origin = (ray.origin - h.offset) / h.spacing, ray.direction = ray.direction / h.spacing;
            const DepthInterval inside =
                clip(ray, glm::dvec3(0), glm::dvec3(h.size - 1), {range.nearest, range.farthest});
            if (!(inside.first < inside.last)) continue;
            const auto hit = s.cast(ray, inside);
            if (!hit) continue;
            const size_t pixel = j * size_t(image.width()) + size_t(i);
            const double length = glm::length(hit->gradient);
            const glm::vec3 normal = length > 0 ? glm::vec3(-hit->gradient / length) : glm::vec3(0);
            const glm::vec3 material(render::kGreyMaterial);
            image.depth[pixel] = image.coding.code(hit->depth);
            image.colour[pixel] = with_normals ? pack_colour(material) : lit_colour(material, normal);
            if (with_normals) image.normal[pixel] = octahedral_code(normal);
        }
    });
    SampleCounts counts;
    counts.clusters = s.ranges.size();
    counts.clusters_touched = size_t(std::count_if(s.touched.begin(), s.touched.end(), [](const auto& t) {
        return t.load(std::memory_order_relaxed) != 0;
    }));
    counts.bytes = h.bytes();
    counts.bytes_touched =
        std::min(h.bytes(), counts.clusters_touched * (h.bytes() / h.samples()) * kBrick * kBrick * kBrick);
    counts.ms = watch.lap_ms();
    return counts;
}

}  // namespace ppve
