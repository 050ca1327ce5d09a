#include "splat/cloud.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <nanoflann.hpp>

#include "core/parallel.h"

namespace splat {

namespace {

constexpr size_t kNeighbours = 12, kTouching = 6;
constexpr float kTouch = 0.8f;
constexpr float kWidest = 4.0f;  // medians: a stray point is no boulder

struct Positions {
    const std::vector<glm::vec3>& p;
    glm::dvec3 middle;
    double inverse_scale;  // brings the cloud to the unit ball, so that squares stay in range
    size_t kdtree_get_point_count() const { return p.size(); }
    double kdtree_get_pt(size_t i, size_t axis) const {
        return (double(p[i][int(axis)]) - middle[int(axis)]) * inverse_scale;
    }
    template <class Box>
    bool kdtree_get_bbox(Box&) const { return false; }
};
using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Positions>, Positions, 3>;

// Eigenvector of the least eigenvalue of a symmetric 3x3 matrix, by Jacobi rotations.
glm::dvec3 least_axis(glm::dmat3 a) {
    glm::dmat3 axes(1.0);
    for (int sweep = 0; sweep < 12; ++sweep) {
        for (int p = 0; p < 2; ++p)
            for (int q = p + 1; q < 3; ++q) {
                if (a[p][q] == 0) continue;
                const double theta = (a[q][q] - a[p][p]) / (2 * a[p][q]);
                const double t = std::copysign(1.0, theta) / (std::fabs(theta) + std::sqrt(theta * theta + 1));
                const double c = 1 / std::sqrt(t * t + 1), s = std::isfinite(t) ? t * c : 0.0;
                glm::dmat3 r(1.0);
                r[p][p] = r[q][q] = c, r[p][q] = -s, r[q][p] = s;
                a = glm::transpose(r) * a * r;
                axes = axes * r;
            }
    }
    int least = 0;
    for (int k = 1; k < 3; ++k)
        if (a[k][k] < a[least][least]) least = k;
    return axes[least];
}

glm::vec3 upward(glm::dvec3 n) {
    const bool down = n.z < 0 || (n.z == 0 && (n.y < 0 || (n.y == 0 && n.x < 0)));
    const double length = glm::length(n);
    return length > 0 ? glm::vec3((down ? -n : n) / length) : glm::vec3(0);
}

}  // namespace

std::vector<float> estimate_discs(mesh::Mesh& mesh) {
    const size_t n = mesh.positions.size();
    glm::dvec3 low(mesh.positions[0]), high = low;
    for (const glm::vec3& p : mesh.positions) low = glm::min(low, glm::dvec3(p)), high = glm::max(high, glm::dvec3(p));
    const double extent = std::max({high.x - low.x, high.y - low.y, high.z - low.z});
    std::vector<float> radii(n, 0.0f);
    if (!(extent > 0)) return radii;
    const Positions positions{mesh.positions, 0.5 * (low + high), 2 / extent};
    const Tree tree(3, positions, nanoflann::KDTreeSingleIndexAdaptorParams(16));
    const bool wants_normals = mesh.normals.empty() && n > 2;
    if (wants_normals) mesh.normals.resize(n);
    const size_t wanted = std::min(n, kNeighbours + 1);  // the point itself is among them
    core::parallel_pieces(n, 4096, [&](size_t begin, size_t end) {
        std::array<uint32_t, kNeighbours + 1> index{};
        std::array<double, kNeighbours + 1> square{};
        for (size_t i = begin; i < end; ++i) {
            const auto at = [&](size_t j) {
                return glm::dvec3(positions.kdtree_get_pt(j, 0), positions.kdtree_get_pt(j, 1), positions.kdtree_get_pt(j, 2));
            };
            const glm::dvec3 point = at(i);
            const size_t found = tree.knnSearch(&point.x, wanted, index.data(), square.data());
            const size_t touching = std::min(found - 1, kTouching);
            radii[i] = float(double(kTouch) * std::sqrt(square[touching]) / positions.inverse_scale);
            if (!wants_normals) continue;
            glm::dvec3 mean(0);
            for (size_t k = 0; k < found; ++k) mean += at(index[k]);
            mean /= double(found);
            glm::dmat3 spread(0.0);
            for (size_t k = 0; k < found; ++k) spread += glm::outerProduct(at(index[k]) - mean, at(index[k]) - mean);
            const double size = spread[0][0] + spread[1][1] + spread[2][2];
            mesh.normals[i] = size > 0 ? upward(least_axis(spread / size)) : glm::vec3(0, 0, 1);
        }
    });
    std::vector<float> sorted;
    std::copy_if(radii.begin(), radii.end(), std::back_inserter(sorted), [](float r) { return r > 0; });
    if (sorted.empty()) return radii;
    std::nth_element(sorted.begin(), sorted.begin() + ptrdiff_t(sorted.size() / 2), sorted.end());
    const float median = sorted[sorted.size() / 2];
    for (float& r : radii) r = r > 0 ? std::min(r, kWidest * median) : median;
    return radii;
}

}  // namespace splat
