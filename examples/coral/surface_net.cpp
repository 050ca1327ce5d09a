#include "surface_net.h"

#include <algorithm>
#include <array>
#include <bitset>
#include <cassert>
#include <cmath>

#include "core/parallel.h"

namespace coral {

namespace {

constexpr int kSide = 8;  // cells along a block
constexpr int kCorners = kSide + 1;
constexpr uint16_t kNoVertex = 0xffff;

// A cube of lattice cells that the surface may cross, and what has been found in it.
struct Block {
    glm::ivec3 first;  // its first cell
    int size = 0;      // cells along a side
    Reef::List segments;

    std::bitset<kCorners * kCorners * kCorners> inside;
    std::array<uint16_t, kSide * kSide * kSide> vertex_of_cell;
    std::vector<glm::vec3> positions;
    std::vector<glm::u8vec3> colours;
    uint32_t first_vertex = 0;
};

size_t corner_index(glm::ivec3 c) {
    return static_cast<size_t>((c.z * kCorners + c.y) * kCorners + c.x);
}
size_t cell_index(glm::ivec3 c) {
    return static_cast<size_t>((c.z * kSide + c.y) * kSide + c.x);
}

struct Lattice {
    const Reef& reef;
    float cell;
    int size;  // cells along a side of the whole, a power of 2

    glm::vec3 at(glm::ivec3 corner) const { return reef.bound_min() + cell * glm::vec3(corner); }
};

// Halves the whole lattice again and again, dropping what the surface does not cross.
std::vector<Block> find_blocks(const Lattice& lattice) {
    std::vector<Block> blocks(1);
    blocks[0].size = lattice.size;
    blocks[0].segments = lattice.reef.all();
    while (blocks[0].size > kSide) {
        const int half = blocks[0].size / 2;
        std::vector<std::vector<Block>> children(blocks.size());
        core::parallel_for(blocks.size(), [&](size_t b) {
            for (int octant = 0; octant < 8; ++octant) {
                Block child;
                child.first = blocks[b].first + half * glm::ivec3(octant & 1, (octant >> 1) & 1, octant >> 2);
                child.size = half;
                const float half_side = 0.5f * lattice.cell * static_cast<float>(half);
                const glm::vec3 centre = lattice.at(child.first) + half_side;
                if (lattice.reef.narrow(blocks[b].segments, centre, std::sqrt(3.0f) * half_side,
                                        child.segments))
                    children[b].push_back(std::move(child));
            }
        });
        blocks.clear();
        for (std::vector<Block>& list : children)
            std::move(list.begin(), list.end(), std::back_inserter(blocks));
    }
    return blocks;
}

// The mean of the points where the surface crosses the cell's edges, then one Newton step towards the
// surface, which brings out relief that is hardly wider than a cell.
glm::vec3 place_vertex(const Lattice& lattice, const Block& block, glm::ivec3 cell,
                       const std::array<float, 8>& value) {
    glm::vec3 sum(0);
    int crossings = 0;
    for (int axis = 0; axis < 3; ++axis)
        for (int from = 0; from < 8; ++from) {
            const int to = from | (1 << axis);
            if (to == from) continue;
            const float v0 = value[static_cast<size_t>(from)], v1 = value[static_cast<size_t>(to)];
            if ((v0 < 0) == (v1 < 0)) continue;
            glm::vec3 p(from & 1, (from >> 1) & 1, from >> 2);
            p[axis] = v0 / (v0 - v1);
            sum += p;
            ++crossings;
        }
    const glm::vec3 low = lattice.at(block.first + cell), high = low + lattice.cell;
    const glm::vec3 p = low + lattice.cell * (sum / static_cast<float>(crossings));
    const float h = 0.25f * lattice.cell, here = lattice.reef.field(block.segments, p);
    const auto slope = [&](glm::vec3 way) {
        return (lattice.reef.field(block.segments, p + h * way) - here) / h;
    };
    const glm::vec3 gradient(slope({1, 0, 0}), slope({0, 1, 0}), slope({0, 0, 1}));
    const float steepness2 = std::max(glm::dot(gradient, gradient), 0.1f);
    return glm::clamp(p - here / steepness2 * gradient, low, high);
}

void fill(const Lattice& lattice, Block& block) {
    std::array<float, kCorners * kCorners * kCorners> value;
    for (int z = 0; z < kCorners; ++z)
        for (int y = 0; y < kCorners; ++y)
            for (int x = 0; x < kCorners; ++x) {
                const glm::ivec3 corner(x, y, z);
                const float v = lattice.reef.field(block.segments, lattice.at(block.first + corner));
                value[corner_index(corner)] = v;
                block.inside[corner_index(corner)] = v < 0;
            }
    block.vertex_of_cell.fill(kNoVertex);
    for (int z = 0; z < kSide; ++z)
        for (int y = 0; y < kSide; ++y)
            for (int x = 0; x < kSide; ++x) {
                std::array<float, 8> of_cell;
                int inside = 0;
                for (int c = 0; c < 8; ++c) {
                    const float v = value[corner_index({x + (c & 1), y + ((c >> 1) & 1), z + (c >> 2)})];
                    of_cell[static_cast<size_t>(c)] = v;
                    inside += v < 0;
                }
                if (inside == 0 || inside == 8) continue;
                const glm::vec3 p = place_vertex(lattice, block, {x, y, z}, of_cell);
                block.vertex_of_cell[cell_index({x, y, z})] = static_cast<uint16_t>(block.positions.size());
                block.positions.push_back(p);
                block.colours.push_back(lattice.reef.colour(block.segments, p));
            }
}

// Finds the vertex of any cell of the lattice.
class VertexMap {
  public:
    VertexMap(const std::vector<Block>& blocks, int lattice_size)
        : blocks_(blocks), side_(lattice_size / kSide), slot_(cube(side_), -1) {
        for (size_t b = 0; b < blocks.size(); ++b)
            slot_[slot_index(blocks[b].first / kSide)] = static_cast<int>(b);
    }
    uint32_t at(glm::ivec3 cell) const {
        const int b = slot_[slot_index(cell / kSide)];
        assert(b >= 0);  // narrow() keeps every block that the surface crosses
        const Block& block = blocks_[static_cast<size_t>(b)];
        const uint16_t vertex = block.vertex_of_cell[cell_index(cell - block.first)];
        assert(vertex != kNoVertex);
        return block.first_vertex + vertex;
    }

  private:
    static size_t cube(int n) {
        return static_cast<size_t>(n) * static_cast<size_t>(n) * static_cast<size_t>(n);
    }
    size_t slot_index(glm::ivec3 block) const {
        return static_cast<size_t>((block.z * side_ + block.y) * side_ + block.x);
    }

    const std::vector<Block>& blocks_;
    int side_;
    std::vector<int> slot_;
};

void add_quad(ColouredMesh& mesh, std::array<uint32_t, 4> v) {
    const auto length = [&](size_t i, size_t j) {
        return glm::distance(mesh.positions[v[i]], mesh.positions[v[j]]);
    };
    const size_t start = length(0, 2) <= length(1, 3) ? 0 : 1;  // split along the shorter diagonal
    const auto corner = [&](size_t i) { return v[(start + i) % 4]; };
    mesh.triangles.push_back({corner(0), corner(1), corner(2)});
    mesh.triangles.push_back({corner(0), corner(2), corner(3)});
}

// A quadrilateral round each edge of the block's lattice that starts in the block and is crossed.
void connect(const Block& block, const VertexMap& vertices, ColouredMesh& mesh) {
    for (int z = 0; z < kSide; ++z)
        for (int y = 0; y < kSide; ++y)
            for (int x = 0; x < kSide; ++x)
                for (int axis = 0; axis < 3; ++axis) {
                    const glm::ivec3 from(x, y, z);
                    glm::ivec3 along(0), u(0), v(0);
                    along[axis] = u[(axis + 1) % 3] = v[(axis + 2) % 3] = 1;
                    const bool in = block.inside[corner_index(from)];
                    if (in == block.inside[corner_index(from + along)]) continue;
                    const glm::ivec3 cell = block.first + from;
                    std::array<uint32_t, 4> quad{vertices.at(cell - u - v), vertices.at(cell - v),
                                                 vertices.at(cell), vertices.at(cell - u)};
                    if (!in) std::swap(quad[1], quad[3]);
                    add_quad(mesh, quad);
                }
}

}  // namespace

ColouredMesh triangulate(const Reef& reef, int resolution) {
    const glm::vec3 extent = reef.bound_max() - reef.bound_min();
    const float longest = std::max({extent.x, extent.y, extent.z});
    Lattice lattice{reef, longest / static_cast<float>(resolution), kSide};
    while (lattice.size < resolution) lattice.size *= 2;

    std::vector<Block> blocks = find_blocks(lattice);
    core::parallel_for(blocks.size(), [&](size_t b) { fill(lattice, blocks[b]); });
    ColouredMesh mesh;
    for (Block& block : blocks) {
        block.first_vertex = static_cast<uint32_t>(mesh.positions.size());
        mesh.positions.insert(mesh.positions.end(), block.positions.begin(), block.positions.end());
        mesh.colours.insert(mesh.colours.end(), block.colours.begin(), block.colours.end());
    }
    const VertexMap vertices(blocks, lattice.size);
    for (const Block& block : blocks) connect(block, vertices, mesh);
    return mesh;
}

}  // namespace coral
