#include "splat/build/cloud.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <nanoflann.hpp>
#include <numeric>
#include <tuple>

#include "core/parallel.h"

namespace splat {

namespace {

constexpr size_t kNeighbours = 12, kTouching = 6;
constexpr float kTouch = 0.8f;
constexpr float kWidest = 4.0f;  // times the widest of the nearest neighbours: a stray point is no boulder
constexpr size_t kNearest = 3;

// Different positions, and which of them each point has: equal points would be each other's neighbours at no
// distance, thousands at a time.
struct Different {
    std::vector<glm::vec3> positions;
    std::vector<uint32_t> of;  // by point
};

Different different_positions(const std::vector<glm::vec3>& all) {
    std::vector<uint32_t> order(all.size());
    std::iota(order.begin(), order.end(), 0u);
    const auto key = [&](uint32_t i) { return std::tie(all[i].x, all[i].y, all[i].z); };
    std::sort(order.begin(), order.end(),
              [&](uint32_t a, uint32_t b) { return key(a) < key(b) || (key(a) == key(b) && a < b); });
    Different d;
    d.of.resize(all.size());
    for (size_t k = 0; k < order.size(); ++k) {
        if (k == 0 || key(order[k]) != key(order[k - 1])) d.positions.push_back(all[order[k]]);
        d.of[order[k]] = uint32_t(d.positions.size() - 1);
    }
    return d;
}

struct Positions {
    const std::vector<glm::vec3>& p;
    glm::dvec3 middle;
    double inverse_scale;  // brings the cloud to the unit ball, so that squares stay in range
    size_t kdtree_get_point_count() const { return p.size(); }
    double kdtree_get_pt(size_t i, size_t axis) const {
        return (double(p[i][int(axis)]) - middle[int(axis)]) * inverse_scale;
    }
    template <class Box>
    bool kdtree_get_bbox(Box&) const {
        return false;
    }
};
using Tree =
    nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Positions>, Positions, 3>;

// Across the plane of least squares of a spread of points (a symmetric matrix), by Jacobi rotations; 0 where
// they lie along a line, which is in many planes.
glm::dvec3 across(glm::dmat3 a) {
    constexpr double kLeastWidth = 0.05;  // of the length
    glm::dmat3 axes(1.0);
    for (int sweep = 0; sweep < 12; ++sweep) {
        for (int p = 0; p < 2; ++p)
            for (int q = p + 1; q < 3; ++q) {
                if (a[p][q] == 0) continue;
                const double theta = (a[q][q] - a[p][p]) / (2 * a[p][q]);
                const double t =
                    std::copysign(1.0, theta) / (std::fabs(theta) + std::sqrt(theta * theta + 1));
                const double c = 1 / std::sqrt(t * t + 1), s = std::isfinite(t) ? t * c : 0.0;
                glm::dmat3 r(1.0);
                r[p][p] = r[q][q] = c, r[p][q] = -s, r[q][p] = s;
                a = glm::transpose(r) * a * r;
                axes = axes * r;
            }
    }
    int order[3] = {0, 1, 2};
    std::sort(order, order + 3, [&](int p, int q) { return a[p][p] < a[q][q]; });
    const double middle = a[order[1]][order[1]], most = a[order[2]][order[2]];
    return middle > kLeastWidth * kLeastWidth * most ? axes[order[0]] : glm::dvec3(0);
}

glm::vec3 upward(glm::dvec3 n) {
    const bool down = n.z < 0 || (n.z == 0 && (n.y < 0 || (n.y == 0 && n.x < 0)));
    const double length = glm::length(n);
    return length > 0 ? glm::vec3((down ? -n : n) / length) : glm::vec3(0);
}

}  // namespace

std::vector<float> estimate_discs(mesh::Mesh& mesh) {
    const Different different = different_positions(mesh.positions);
    const size_t n = different.positions.size();
    glm::dvec3 low(mesh.positions[0]), high = low;
    for (const glm::vec3& p : mesh.positions)
        low = glm::min(low, glm::dvec3(p)), high = glm::max(high, glm::dvec3(p));
    const double extent = std::max({high.x - low.x, high.y - low.y, high.z - low.z});
    std::vector<float> radii(n, 0.0f);
    if (!(extent > 0)) return std::vector<float>(mesh.positions.size(), 0.0f);
    const Positions positions{different.positions, 0.5 * (low + high), 2 / extent};
    const Tree tree(3, positions, nanoflann::KDTreeSingleIndexAdaptorParams(16));
    const bool wants_normals = mesh.normals.empty() && n > 2;
    std::vector<glm::vec3> normals(wants_normals ? n : 0);
    std::vector<std::array<uint32_t, kNearest>> nearest(n);
    const size_t wanted = std::min(n, kNeighbours + 1);  // the point itself is among them
    core::parallel_pieces(n, 4096, [&](size_t begin, size_t end) {
        std::array<uint32_t, kNeighbours + 1> index{};
        std::array<double, kNeighbours + 1> square{};
        for (size_t i = begin; i < end; ++i) {
            const auto at = [&](size_t j) {
                return glm::dvec3(positions.kdtree_get_pt(j, 0), positions.kdtree_get_pt(j, 1),
                                  positions.kdtree_get_pt(j, 2));
            };
            const glm::dvec3 point = at(i);
            const size_t found = tree.knnSearch(&point.x, wanted, index.data(), square.data());
            const size_t touching = std::min(found - 1, kTouching);
            radii[i] = float(double(kTouch) * std::sqrt(square[touching]) / positions.inverse_scale);
            for (size_t k = 0; k < kNearest; ++k) nearest[i][k] = index[std::min(k + 1, found - 1)];
            if (!wants_normals) continue;
            glm::dvec3 mean(0);
            for (size_t k = 0; k < found; ++k) mean += at(index[k]);
            mean /= double(found);
            glm::dmat3 spread(0.0);
            for (size_t k = 0; k < found; ++k)
                spread += glm::outerProduct(at(index[k]) - mean, at(index[k]) - mean);
            const double size = spread[0][0] + spread[1][1] + spread[2][2];
            normals[i] = size > 0 ? upward(across(spread / size)) : glm::vec3(0);
        }
    });
    std::vector<float> capped(n);
    for (size_t i = 0; i < n; ++i) {
        float widest = 0;
        for (const uint32_t k : nearest[i]) widest = std::max(widest, radii[k]);
        capped[i] = std::min(radii[i], kWidest * widest);
    }
    std::vector<float> result(mesh.positions.size());
    if (wants_normals) mesh.normals.resize(result.size());
    for (size_t i = 0; i < result.size(); ++i) {
        result[i] = capped[different.of[i]];
        if (wants_normals) mesh.normals[i] = normals[different.of[i]];
    }
    return result;
}

}  // namespace splat
