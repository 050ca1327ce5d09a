#include "ppve/patch.h"

#include <xxhash.h>

#include <algorithm>

namespace ppve {

namespace {

template <class T>
uint64_t hash_of(const std::vector<T>& values, uint64_t seed) {
    return XXH3_64bits_withSeed(values.data(), values.size() * sizeof(T), seed);
}

template <class T>
size_t bytes_of(const std::vector<T>& values) {
    return values.capacity() * sizeof(T);
}

}  // namespace

void PatchPoints::reserve(size_t count, bool with_normals) {
    for (auto* axis : {&x, &y, &z}) axis->reserve(count);
    colour.reserve(count);
    if (with_normals) normal.reserve(count);
}

void PatchPoints::take(const PatchPoints& from, size_t i, bool with_normals) {
    x.push_back(from.x[i]);
    y.push_back(from.y[i]);
    z.push_back(from.z[i]);
    colour.push_back(from.colour[i]);
    if (with_normals) normal.push_back(from.normal[i]);
}

Patch::Patch(std::shared_ptr<const Sampling> sampling, const glm::dvec3& anchor, double unit,
             PatchPoints points)
    : sampling_(std::move(sampling)), anchor_(anchor), points_(std::move(points)) {
    const std::vector<float>* const axes[] = {&points_.x, &points_.y, &points_.z};
    for (int k = 0; k < 3; ++k) {
        const auto [low, high] = std::minmax_element(axes[k]->begin(), axes[k]->end());
        low_[k] = *low, high_[k] = *high;
    }
    const Frustum& frustum = sampling_->frustum;
    const double depth = glm::dot(frustum.view.forward, anchor_ - frustum.view.eye);
    footprint_ = static_cast<float>(footprint(frustum, sampling_->footprint_px, depth) / unit);
    const bool grows = frustum.projection == Projection::perspective;
    footprint_slope_ =
        glm::vec3(frustum.view.forward * (grows ? sampling_->footprint_px / frustum.view.focal_px : 0.0));
    hash_ = sampling_->update;
    for (const auto* axis : axes) hash_ = hash_of(*axis, hash_);
    hash_ = hash_of(points_.normal, hash_of(points_.colour, hash_));
    hash_ = XXH3_64bits_withSeed(&anchor_, sizeof anchor_, hash_);
}

size_t Patch::bytes() const {
    return sizeof *this + bytes_of(points_.x) + bytes_of(points_.y) + bytes_of(points_.z) +
           bytes_of(points_.colour) + bytes_of(points_.normal);
}

}  // namespace ppve
