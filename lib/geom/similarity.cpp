#include "geom/similarity.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/error.h"

namespace geom {
namespace {

constexpr double kFarthest = 1e150, kSmallestScale = 1e-100, kLargestScale = 1e100;
constexpr double kOff = 1e-5;  // matrices are written with six digits and more

// With white space or a comma between.
std::vector<double> parse_numbers(std::string_view text, const std::string& name) {
    std::vector<double> numbers;
    const std::string_view blanks = " \t\r\n", separators = ", \t\r\n";
    const auto after_blanks = [&](size_t at) {
        return std::min(text.find_first_not_of(blanks, at), text.size());
    };
    bool is_after_comma = false;
    for (size_t at = after_blanks(0); at < text.size() || is_after_comma;) {
        if (at == text.size() || text[at] == ',')
            throw core::Error(
                name + core::text(": a comma without a number %s it", at < text.size() ? "before" : "after"));
        const size_t end = std::min(text.find_first_of(separators, at), text.size());
        const std::string_view word = text.substr(at, end - at);
        const size_t sign = word.starts_with('+');  // which from_chars does not take
        double value = 0;
        const auto [rest, error] = std::from_chars(word.data() + sign, word.data() + word.size(), value);
        if (error != std::errc() || rest != word.data() + word.size() || !(std::abs(value) <= kFarthest))
            throw core::Error(name + ": '" + std::string(word) + "' is not a finite number up to 1e150");
        numbers.push_back(value);
        at = after_blanks(end);
        is_after_comma = at < text.size() && text[at] == ',';
        if (is_after_comma) at = after_blanks(at + 1);
    }
    return numbers;
}

glm::dmat3 turn(int axis, double degrees) {
    const double angle = degrees * std::numbers::pi / 180, c = std::cos(angle), s = std::sin(angle);
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    glm::dmat3 m(1);
    m[u][u] = c, m[u][v] = s, m[v][u] = -s, m[v][v] = c;  // m[column][row]
    return m;
}

// The orthonormal matrix nearest to one that nearly is.  Newton's iteration for the polar decomposition
// (Higham. Computing the polar decomposition, with applications.  1986).
glm::dmat3 orthonormal(glm::dmat3 m) {
    for (int i = 0; i < 4; ++i) m = 0.5 * (m + glm::transpose(glm::inverse(m)));
    return m;
}

Similarity similarity_of_matrix(const std::vector<double>& rows, const std::string& name) {
    if (rows[12] != 0 || rows[13] != 0 || rows[14] != 0 || rows[15] != 1)
        throw core::Error(core::text("%s: the last row of the matrix is %g %g %g %g; it must be 0 0 0 1",
                                     name.c_str(), rows[12], rows[13], rows[14], rows[15]));
    glm::dmat3 m;
    double largest = 0;
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 3; ++column) {
            m[column][row] = rows[size_t(4 * row + column)];
            largest = std::max(largest, std::abs(m[column][row]));
        }
    Similarity s;
    s.translation = {rows[3], rows[7], rows[11]};
    if (largest == 0) throw core::Error(name + ": the matrix takes all to one point");
    m /= largest;
    const double scale = std::sqrt((glm::dot(m[0], m[0]) + glm::dot(m[1], m[1]) + glm::dot(m[2], m[2])) / 3);
    m /= scale;
    s.scale = scale * largest;
    const glm::dmat3 product = glm::transpose(m) * m;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            if (!(std::abs(product[i][j] - (i == j ? 1 : 0)) <= kOff))
                throw core::Error(name +
                                  ": the matrix shears or scales unevenly; only rotation, uniform scale and "
                                  "translation can be drawn");
    s.rotation = orthonormal(m);
    return s;
}

Similarity similarity_of_numbers(const std::vector<double>& n, const std::string& name) {
    if (n.size() != 3 && n.size() != 4 && n.size() != 7 && n.size() != 16)
        throw core::Error(
            core::text("%s: has %zu numbers; a transform is 3 (X,Y,Z), 4 (and SCALE), 7 (and "
                       "degrees RX,RY,RZ) or 16 (a 4 x 4 matrix)",
                       name.c_str(), n.size()));
    if (n.size() == 16) return similarity_of_matrix(n, name);
    Similarity s;
    s.translation = {n[0], n[1], n[2]};
    if (n.size() > 3) s.scale = n[3];
    if (n.size() > 4) s.rotation = turn(2, n[6]) * turn(1, n[5]) * turn(0, n[4]);
    return s;
}

}  // namespace

View view_in(const Similarity& t, const View& view) {
    const glm::dmat3 inverse = glm::transpose(t.rotation);
    View inner = view;
    inner.eye = t.inverse_point(view.eye);
    inner.right = inverse * view.right, inner.down = inverse * view.down;
    inner.forward = inverse * view.forward;
    if (view.near) inner.near = *view.near / t.scale;
    if (view.far) inner.far = *view.far / t.scale;
    return inner;
}

Sphere placed(const Sphere& inner, const Similarity& t) {
    return {t.point(inner.centre), inner.radius * t.scale};
}

Sphere sphere_around(const Sphere& a, const Sphere& b) {
    const glm::dvec3 between = b.centre - a.centre;
    const double distance = std::hypot(between.x, between.y, between.z);
    if (distance + b.radius <= a.radius) return a;
    if (distance + a.radius <= b.radius) return b;
    const double radius = 0.5 * (a.radius + distance + b.radius);
    return {a.centre + between * ((radius - a.radius) / distance), radius};
}

Similarity parse_similarity(std::string_view text, const std::string& name) {
    const Similarity s = similarity_of_numbers(parse_numbers(text, name), name);
    if (!(s.scale >= kSmallestScale && s.scale <= kLargestScale))
        throw core::Error(
            core::text("%s: the scale, %g, is not from 1e-100 to 1e100", name.c_str(), s.scale));
    return s;
}

}  // namespace geom
