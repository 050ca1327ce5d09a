#include "shapes.h"

#include <cmath>
#include <cstddef>
#include <numbers>

#include "core/bytes.h"

namespace stability {

Shape bumpy_sphere() {
    constexpr uint32_t kRings = 40, kAround = 60;
    Shape shape;
    const auto add = [&](double polar, double around) {
        const double radius = 1 + 0.1 * std::sin(5 * polar + 2 * around) * std::sin(polar) +
                              0.05 * std::sin(17 * polar) * std::cos(13 * around) * std::sin(polar);
        shape.vertices.push_back(radius * glm::dvec3(std::sin(polar) * std::cos(around), std::cos(polar),
                                                     std::sin(polar) * std::sin(around)));
    };
    for (uint32_t ring = 1; ring <= kRings; ++ring)
        for (uint32_t k = 0; k < kAround; ++k)
            add(std::numbers::pi * ring / (kRings + 1), 2 * std::numbers::pi * k / kAround);
    const uint32_t north = kRings * kAround, south = north + 1;
    shape.vertices.emplace_back(0, 1, 0), shape.vertices.emplace_back(0, -1, 0);
    for (uint32_t k = 0; k < kAround; ++k) {
        const uint32_t next = (k + 1) % kAround, last = (kRings - 1) * kAround;
        shape.triangles.push_back({north, next, k});
        for (uint32_t ring = 0; ring + 1 < kRings; ++ring) {
            const uint32_t a = ring * kAround + k, b = ring * kAround + next;
            shape.triangles.push_back({a, b, a + kAround});
            shape.triangles.push_back({b, b + kAround, a + kAround});
        }
        shape.triangles.push_back({south, last + k, last + next});
    }
    return shape;
}

Shape tetrahedron() {
    return {{{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}}, {{0, 1, 2}, {0, 3, 1}, {0, 2, 3}, {1, 3, 2}}};
}

Shape slivers(int count, double aspect) {
    Shape shape;
    for (int k = 0; k < count; ++k) {
        const auto first = uint32_t(shape.vertices.size());
        const double y = k / aspect;
        shape.vertices.insert(shape.vertices.end(), {{0, y, 0}, {1, y, 0}, {0.5, y + 1 / aspect, 0}});
        shape.triangles.push_back({first, first + 1, first + 2});
    }
    return shape;
}

Shape halving_spacing(int octaves) {
    Shape shape;
    for (int k = 0; k <= octaves; ++k) {
        const double r = std::ldexp(1.0, -k);
        for (int corner = 0; corner < 3; ++corner) {
            const double angle = 2 * std::numbers::pi * corner / 3 + k;
            shape.vertices.emplace_back(r, 0.5 * r * std::cos(angle), 0.5 * r * std::sin(angle));
        }
        if (k == 0) continue;
        const auto last = uint32_t(3 * k - 3), next = uint32_t(3 * k);
        for (uint32_t corner = 0; corner < 3; ++corner) {
            const uint32_t other = (corner + 1) % 3;
            shape.triangles.push_back({last + corner, next + corner, last + other});
            shape.triangles.push_back({last + other, next + corner, next + other});
        }
    }
    const auto tip = uint32_t(shape.vertices.size() - 3);
    shape.triangles.push_back({0, 1, 2});
    shape.triangles.push_back({tip, tip + 2, tip + 1});
    return shape;
}

Shape terrain(double size) {
    constexpr uint32_t kSide = 65;
    Shape shape;
    for (uint32_t i = 0; i < kSide; ++i)
        for (uint32_t j = 0; j < kSide; ++j) {
            const double x = double(i) / (kSide - 1) - 0.5, z = double(j) / (kSide - 1) - 0.5;
            const double height = 0.03 * std::sin(9 * x + 1) * std::cos(7 * z) + 0.005 * std::sin(31 * x * z);
            shape.vertices.emplace_back(size * x, size * height, size * z);
        }
    for (uint32_t i = 0; i + 1 < kSide; ++i)
        for (uint32_t j = 0; j + 1 < kSide; ++j) {
            const uint32_t a = i * kSide + j;
            shape.triangles.push_back({a, a + 1, a + kSide});
            shape.triangles.push_back({a + 1, a + kSide + 1, a + kSide});
        }
    return shape;
}

Shape placed(Shape shape, double scale, const glm::dvec3& offset) {
    for (glm::dvec3& v : shape.vertices) v = scale * v + offset;
    return shape;
}

// Not inline: g++ 12 drops the way through single precision where it vectorises neighbouring coordinates.
double rounded(double value, Precision precision) {
    return precision == Precision::single ? double(float(value)) : value;
}

Shape joined(Shape a, const Shape& b) {
    const auto first = uint32_t(a.vertices.size());
    a.vertices.insert(a.vertices.end(), b.vertices.begin(), b.vertices.end());
    for (const glm::u32vec3& t : b.triangles) a.triangles.push_back(t + first);
    return a;
}

std::string to_ply(const Shape& shape, Precision precision) {
    const std::string type = precision == Precision::single ? "float" : "double";
    std::string ply = "ply\nformat binary_little_endian 1.0\nelement vertex " +
                      std::to_string(shape.vertices.size()) + "\nproperty " + type + " x\nproperty " + type +
                      " y\nproperty " + type + " z\n";
    if (!shape.triangles.empty())
        ply += "element face " + std::to_string(shape.triangles.size()) +
               "\nproperty list uchar uint vertex_indices\n";
    ply += "end_header\n";
    core::ByteWriter body;
    for (const glm::dvec3& v : shape.vertices)
        for (int k = 0; k < 3; ++k) {
            if (precision == Precision::single)
                body.put(float(v[k]));
            else
                body.put(v[k]);
        }
    for (const glm::u32vec3& t : shape.triangles) {
        body.put(uint8_t(3));
        for (int k = 0; k < 3; ++k) body.put(t[k]);
    }
    ply.append(reinterpret_cast<const char*>(body.bytes.data()), body.bytes.size());
    return ply;
}

}  // namespace stability
