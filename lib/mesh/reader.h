// What the readers of all formats share: the bytes they read, and how the file's vertices and
// faces become those of a Mesh, with every loss counted.
#pragma once

#include <functional>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/file.h"
#include "mesh/mesh.h"

namespace mesh {

// The bytes of one input, and its name for messages.
struct Source {
    std::span<const std::byte> bytes;
    std::string name;
    const core::InputFile* file = nullptr;  // null: the bytes are not a mapped file

    std::string_view text() const { return {reinterpret_cast<const char*>(bytes.data()), bytes.size()}; }

    // The bytes [begin, end) will not be read again.
    void forget(size_t begin, size_t end) const {
        if (file != nullptr) file->forget(begin, end);
    }
};

// A word of the file for a message: in quotes, at most 40 characters, unprintable ones as '?'.
std::string quoted(std::string_view word);

// Collects the file's faces as triangles.  Indices are checked against `vertex_count`, which the
// reader knows (and has checked against the file's size) beforehand.
class Faces {
  public:
    // Throws Error where there are more vertices than a triangle can name.
    Faces(const Source& source, uint64_t vertex_count, ReadResult& result);

    // One polygon, fanned from its first corner.  Fewer than three corners count as one triangle
    // that is dropped.  Throws Error "file: face F uses vertex I, file has N vertices".
    void polygon(std::span<const int64_t> corners);

    // Triangle strips with -1 between them; every strip is a face, its odd triangles are turned.
    void strips(std::span<const int64_t> corners);

  private:
    void strip(std::span<const int64_t> corners);
    void check(std::span<const int64_t> corners) const;
    void add(int64_t a, int64_t b, int64_t c);

    const Source& source_;
    uint64_t vertex_count_;
    ReadResult& result_;
};

// Drops the triangles that name a vertex twice, and counts them.
void drop_repeated(ReadResult& result);

// Coordinates up to here are kept relative to an origin: the difference of two of them is still
// finite in single precision.
constexpr double kLargestCoordinate = std::numeric_limits<float>::max() / 2;

// The origin for `count` points, of which point_at(i) gives the coordinates: the median, by axis, of some
// thousands of them, so that a few that lie far away (many files have such a vertex, in no face) do not cost
// the others their digits.  0 where none of these is usable.
glm::dvec3 origin_among(uint64_t count, const std::function<glm::dvec3(uint64_t)>& point_at);

// `point` relative to `origin` in single precision; NaN where a coordinate is not finite,
// infinity where one is larger than kLargestCoordinate.
glm::vec3 relative_to(const glm::dvec3& origin, const glm::dvec3& point);

// `value` in single precision, beyond its range infinite.
float to_single(double value);

// Sets the mesh's origin among `points`, and its positions relative to it.
void place_points(std::span<const glm::dvec3> points, Mesh& mesh);

// Unit length, or zero where the direction is unknown.
glm::vec3 unit_normal(const glm::dvec3& normal);

// Colour from a fraction 0..1, cut off at both ends; NaN is 0.
uint8_t colour_from_fraction(double fraction);

// Refuses the first vertex whose position is not finite, or with skip_bad drops all of these and
// the triangles that use them.  `is_placed`: positions come from relative_to().
void settle_bad_vertices(const Source& source, const ReadOptions& options, bool is_placed,
                         ReadResult& result);

}  // namespace mesh
