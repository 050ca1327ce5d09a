#include "pm/bounds.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace pm {

namespace {

constexpr double power_of_two(int exponent) {
    double value = 1;
    for (; exponent > 0; --exponent) value *= 2;
    for (; exponent < 0; ++exponent) value /= 2;
    return value;
}

constexpr auto kRadii = [] {
    std::array<double, kMaxRadiusCode + 1> radii{};
    for (int code = 0; code <= kMaxRadiusCode; ++code) radii[size_t(code)] = power_of_two(code - 48);
    return radii;
}();

constexpr auto kErrors = [] {
    // 2^(1/4), 2^(1/2), 2^(3/4), to the last bit.
    constexpr double kQuarters[4] = {1, 0x1.306fe0a31b715p+0, 0x1.6a09e667f3bcdp+0, 0x1.ae89f995ad3adp+0};
    std::array<double, 256> errors{};
    for (int code = 0; code < 256; ++code)
        errors[size_t(code)] = kQuarters[code % 4] * power_of_two(code / 4 - 48);
    return errors;
}();

template <class Lattice>
uint8_t round_up(const Lattice& lattice, double value) {
    const auto at = std::lower_bound(lattice.begin(), lattice.end(), value);
    return uint8_t(std::min<size_t>(size_t(at - lattice.begin()), lattice.size() - 1));
}

// Octahedral map: the sphere's upper half to the square's inner diamond, the lower half folded outwards.
glm::dvec2 fold(const glm::dvec2& p) {
    return {(1 - std::fabs(p.y)) * (p.x < 0 ? -1 : 1), (1 - std::fabs(p.x)) * (p.y < 0 ? -1 : 1)};
}

uint16_t encode_octahedral(const glm::dvec3& direction, int bits) {
    // By the largest coordinate first, so that no length overflows or vanishes.
    const double largest = std::max({std::fabs(direction.x), std::fabs(direction.y), std::fabs(direction.z)});
    const glm::dvec3 d = direction / largest;
    glm::dvec2 p = glm::dvec2(d.x, d.y) / (std::fabs(d.x) + std::fabs(d.y) + std::fabs(d.z));
    if (d.z < 0) p = fold(p);
    const double steps = double((1 << bits) - 1);
    const auto step = [&](double x) {
        return uint32_t(std::clamp(std::floor((x + 1) * 0.5 * steps + 0.5), 0.0, steps));
    };
    return uint16_t(step(p.x) | step(p.y) << bits);
}

glm::dvec3 decode_octahedral(uint16_t code, int bits) {
    const double steps = double((1 << bits) - 1);
    const auto place = [&](uint32_t step) { return 2 * double(step) / steps - 1; };
    glm::dvec2 p{place(code & ((1u << bits) - 1)), place(uint32_t(code) >> bits)};
    const double z = 1 - std::fabs(p.x) - std::fabs(p.y);
    if (z < 0) p = fold(p);
    const double length = std::sqrt(p.x * p.x + p.y * p.y + z * z);
    return glm::dvec3(p, z) / length;
}

constexpr int kAxisBits = 6, kNormalBits = 8;
constexpr uint16_t kUnknownNormal = 0xffff;

}  // namespace

double decode_radius(uint8_t code) {
    return kRadii[std::min(code, kMaxRadiusCode)];
}
double decode_error(uint8_t code) {
    return kErrors[code];
}
uint8_t encode_radius(double radius) {
    return round_up(kRadii, radius);
}
uint8_t encode_error(double error) {
    return round_up(kErrors, error);
}

Cone decode_cone(uint16_t axis, uint8_t angle) {
    const double t = double(angle) / 31, scale = 1 + t * t;
    return {decode_octahedral(axis, kAxisBits), 2 * t / scale, (1 - t * t) / scale};
}

ConeCodes encode_cone(const glm::dvec3& axis, double half_angle) {
    ConeCodes codes;
    codes.axis = encode_octahedral(axis, kAxisBits);
    const glm::dvec3 coded = decode_octahedral(codes.axis, kAxisBits);
    const glm::dvec3 unit = glm::normalize(axis);
    const double off = std::atan2(glm::length(glm::cross(unit, coded)), glm::dot(unit, coded));
    // Wider by more than these functions' rounding.
    const double t = 31 * std::tan(std::min(0.5 * (half_angle + off) + 1e-9, 1.5));
    codes.angle = t > 30 ? kAnyDirection : uint8_t(std::ceil(t));
    return codes;
}

uint16_t encode_normal(const glm::dvec3& normal) {
    if (normal == glm::dvec3(0)) return kUnknownNormal;
    const uint16_t code = encode_octahedral(normal, kNormalBits);
    // All four corners of the square are the direction -z.
    return code == kUnknownNormal ? 0 : code;
}

glm::dvec3 decode_normal(uint16_t code) {
    return code == kUnknownNormal ? glm::dvec3(0) : decode_octahedral(code, kNormalBits);
}

}  // namespace pm
