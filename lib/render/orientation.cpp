#include "render/orientation.h"

#include <cmath>

namespace render {

namespace {

// A sum held without rounding error: components of increasing magnitude that do not overlap, none of them
// zero, so that the last one has the sign of the whole.
class ExactSum {
  public:
    void add_product(double a, double b, double c) {
        const double high = a * b;
        const double low = std::fma(a, b, -high);
        add_product(low, c);
        add_product(high, c);
    }

    int sign() const { return count_ == 0 ? 0 : parts_[count_ - 1] > 0 ? 1 : -1; }

  private:
    void add_product(double a, double b) {
        const double high = a * b;
        add(std::fma(a, b, -high));
        add(high);
    }

    // Shewchuk's GROW-EXPANSION, leaving out zeros.
    void add(double term) {
        int kept = 0;
        for (int i = 0; i < count_; ++i) {
            const double sum = term + parts_[i];
            const double part_taken = sum - term;
            const double error = (term - (sum - part_taken)) + (parts_[i] - part_taken);
            if (error != 0) parts_[kept++] = error;
            term = sum;
        }
        if (term != 0) parts_[kept++] = term;
        count_ = kept;
    }

    double parts_[24];  // six products of three factors, four components each
    int count_ = 0;
};

}  // namespace

int orientation(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
    ExactSum sum;
    sum.add_product(a.y, b.z, c.x);
    sum.add_product(-a.z, b.y, c.x);
    sum.add_product(a.z, b.x, c.y);
    sum.add_product(-a.x, b.z, c.y);
    sum.add_product(a.x, b.y, c.z);
    sum.add_product(-a.y, b.x, c.z);
    return sum.sign();
}

}  // namespace render
