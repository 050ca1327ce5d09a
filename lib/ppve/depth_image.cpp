#include "ppve/depth_image.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "core/error.h"

namespace ppve {

namespace {

constexpr int kDoubleMantissaBits = 52;
constexpr int64_t kMostCode = 0xffffffff;
constexpr int kMostStepBits = 1000;
constexpr double kMostSteps = 0x1p53;  // orthographic: that are told apart from their neighbours
constexpr double kMostFocal = 1e30, kMostShift = 1e15;

// Nearest multiple of 2^-bits, in these units; a half goes up.
int64_t steps_of(double depth, int bits) {
    constexpr double kMost = 0x1p62;
    return int64_t(std::clamp(std::floor(std::ldexp(depth, bits) + 0.5), -kMost, kMost));
}

// The sign-less bits of 1 / depth, rounded to `bits` of mantissa; 0 for what is at or behind the eye.
int64_t leading_bits(double depth, int bits) {
    const double inverse = 1 / std::clamp(depth, kLeastDepth, kMostDepth);
    const int dropped = kDoubleMantissaBits - bits;
    const uint64_t half = dropped > 0 ? uint64_t(1) << (dropped - 1) : 0;
    return int64_t((std::bit_cast<uint64_t>(inverse) + half) >> dropped);
}

int64_t key_of(Projection projection, double depth, int bits) {
    return projection == Projection::perspective ? leading_bits(depth, bits) : -steps_of(depth, bits);
}

bool is_finite(const glm::dvec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

bool is_orthonormal(const geom::View& view) {
    const glm::dmat3 axes(view.right, view.down, view.forward);
    const glm::dmat3 products = glm::transpose(axes) * axes;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            if (!(std::abs(products[i][j] - (i == j ? 1 : 0)) <= 1e-9)) return false;
    return true;
}

void check_depths(const Frustum& frustum, const std::string& where) {
    const bool perspective = frustum.projection == Projection::perspective;
    const auto is_depth = [&](double depth) {
        return std::isfinite(depth) && std::abs(depth) <= kMostDepth &&
               (!perspective || depth >= kLeastDepth);
    };
    const geom::View& v = frustum.view;
    if ((v.near && !is_depth(*v.near)) || (v.far && !is_depth(*v.far)) ||
        (v.near && v.far && !(*v.near < *v.far)))
        throw core::Error(core::text("%s: near %g and far %g are not depths one behind the other",
                                     where.c_str(), v.near.value_or(0), v.far.value_or(0)));
}

}  // namespace

void check(const Frustum& frustum, const std::string& where) {
    const geom::View& v = frustum.view;
    if (v.width < 1 || v.height < 1 || v.width > kMostSide || v.height > kMostSide)
        throw core::Error(core::text("%s: %d x %d pixels; a side has 1 to %d", where.c_str(), v.width,
                                     v.height, kMostSide));
    if (!(v.focal_px > 0 && v.focal_px <= kMostFocal))
        throw core::Error(core::text("%s: a focal length of %g pixels", where.c_str(), v.focal_px));
    if (!(std::abs(v.shift_px.x) <= kMostShift && std::abs(v.shift_px.y) <= kMostShift))
        throw core::Error(core::text("%s: the frustum is shifted by %g, %g pixels", where.c_str(),
                                     v.shift_px.x, v.shift_px.y));
    const glm::dvec3 reach = glm::abs(v.eye);
    if (!is_finite(v.eye) || std::max({reach.x, reach.y, reach.z}) > kMostCoordinate)
        throw core::Error(
            core::text("%s: the eye is at %g, %g, %g", where.c_str(), v.eye.x, v.eye.y, v.eye.z));
    if (!is_orthonormal(v)) throw core::Error(where + ": the axes are not unit vectors at right angles");
    check_depths(frustum, where);
}

uint32_t DepthCoding::code(double depth) const {
    return uint32_t(std::clamp<int64_t>(key_of(projection, depth, bits) - base, 1, kMostCode));
}

double DepthCoding::depth(uint32_t code) const {
    const int64_t key = base + int64_t(code);
    if (projection == Projection::orthographic) return std::ldexp(-double(key), -bits);
    // Not all codes are used where bits are few: beyond the last one they are the nearest depth there is.
    const int64_t last = leading_bits(kLeastDepth, bits);
    return 1 / std::bit_cast<double>(uint64_t(std::min(key, last)) << (kDoubleMantissaBits - bits));
}

bool is_valid(const DepthCoding& coding) {
    if (coding.projection == Projection::perspective)
        return coding.bits >= 1 && coding.bits <= kDoubleMantissaBits &&
               coding.base >= leading_bits(kMostDepth, coding.bits) - 2 &&
               coding.base <= leading_bits(kLeastDepth, coding.bits);
    return std::abs(coding.bits) <= kMostStepBits && std::abs(double(coding.base)) <= kMostSteps &&
           std::ldexp(std::abs(double(coding.base)) + double(kMostCode), -coding.bits) <= 4 * kMostDepth;
}

DepthCoding choose_coding(const Frustum& frustum, double bound_px, double nearest, double farthest) {
    const bool perspective = frustum.projection == Projection::perspective;
    const int wanted = bound_px > 0
                           ? int(std::clamp(std::ceil(std::log2(frustum.view.focal_px / bound_px)) - 1,
                                            -1.0 * kMostStepBits, 1.0 * kMostStepBits))
                           : kFloatMantissaBits;
    DepthCoding coding{.projection = frustum.projection,
                       .bits = perspective ? std::clamp(wanted, 1, kDoubleMantissaBits) : wanted};
    // Codes 0 and 1 are kept free of depths, so that rounding at the far end has room.
    const auto span = [&] {
        return double(key_of(frustum.projection, nearest, coding.bits)) -
               double(key_of(frustum.projection, farthest, coding.bits));
    };
    const auto fits = [&] {
        return span() < double(kMostCode) - 4 &&
               (perspective ||
                std::ldexp(std::max(std::abs(nearest), std::abs(farthest)), coding.bits) < kMostSteps / 2);
    };
    while (coding.bits > (perspective ? 1 : -kMostStepBits) && !fits()) --coding.bits;
    coding.base = key_of(frustum.projection, farthest, coding.bits) - 2;
    return coding;
}

double bound_px(const DepthCoding& coding, double focal_px) {
    return std::ldexp(focal_px, -(coding.bits + 1));
}

size_t DepthImage::samples() const {
    return depth.size() - size_t(std::count(depth.begin(), depth.end(), 0u));
}

void DepthImage::clear(bool with_normals) {
    depth.assign(pixels(), 0);
    colour.assign(pixels(), 0);
    normal.assign(with_normals ? pixels() : 0, 0);
}

glm::dvec3 position_of(const Frustum& frustum, const DepthCoding& coding, int i, int j, uint32_t code) {
    const geom::View& v = frustum.view;
    const double depth = coding.depth(code);
    const double across = (frustum.projection == Projection::perspective ? depth : 1) / v.focal_px;
    const glm::dvec2 at = (glm::dvec2(i + 0.5, j + 0.5) - v.principal()) * across;
    return v.eye + (v.right * at.x + v.down * at.y + v.forward * depth);
}

Projected project(const Frustum& frustum, const glm::dvec3& world) {
    const geom::View& v = frustum.view;
    const glm::dvec3 p = v.view_from_world(world);
    const double across = v.focal_px / (frustum.projection == Projection::perspective ? p.z : 1);
    return {v.principal().x + p.x * across, v.principal().y + p.y * across, p.z};
}

double footprint(const Frustum& frustum, double footprint_px, double depth) {
    return (frustum.projection == Projection::perspective ? depth : 1) / frustum.view.focal_px * footprint_px;
}

uint16_t octahedral_code(const glm::vec3& normal) {
    const float length = std::abs(normal.x) + std::abs(normal.y) + std::abs(normal.z);
    if (!(length > 0) || !std::isfinite(length)) return kUnknownNormal;
    glm::vec2 at(normal.x / length, normal.y / length);
    if (normal.z < 0) at = {std::copysign(1 - std::abs(at.y), at.x), std::copysign(1 - std::abs(at.x), at.y)};
    const auto byte = [](float coordinate) {
        return uint8_t(int8_t(std::clamp(std::floor(coordinate * 127 + 0.5f), -127.0f, 127.0f)));
    };
    return uint16_t(byte(at.x) | byte(at.y) << 8);
}

glm::vec3 octahedral_normal(uint16_t code) {
    if (code == kUnknownNormal) return glm::vec3(0);
    const glm::vec2 at(float(int8_t(code & 0xff)) / 127, float(int8_t(code >> 8)) / 127);
    glm::vec3 n(at.x, at.y, 1 - std::abs(at.x) - std::abs(at.y));
    const float fold = std::max(-n.z, 0.0f);
    n.x -= std::copysign(fold, n.x), n.y -= std::copysign(fold, n.y);
    return glm::normalize(n);
}

}  // namespace ppve
