// How large the triangles of a block of nodes are: what tells whether a view wants most of them.
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <vector>

namespace splat {

class TriangleSizes {
  public:
    // On the lattice.
    void add(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
        const glm::dvec3 p = b - a, q = c - b, r = a - c;
        squares_.push_back(std::max(glm::dot(p, p), std::max(glm::dot(q, q), glm::dot(r, r))));
    }
    bool empty() const { return squares_.empty(); }

    // The longest side of the middle triangle, of two the larger; then there are none.  step: of the lattice.
    float take_middle(double step) {
        const auto middle = squares_.begin() + ptrdiff_t(squares_.size() / 2);
        std::nth_element(squares_.begin(), middle, squares_.end());
        const double side = std::sqrt(*middle) * step;
        squares_.clear();
        return float(side);
    }

  private:
    std::vector<double> squares_;
};

}  // namespace splat
