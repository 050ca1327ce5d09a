#include "hybrid_scene.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <memory>
#include <random>

#include "core/parallel.h"
#include "render/raster.h"
#include "render/splatter.h"

namespace render_test {
namespace {

using render::SplatBatch;
using render::TriangleBatch;

void put(SplatBatch& batch, const Disc& d) {
    const size_t k = size_t(batch.count++);
    batch.x[k] = d.centre.x, batch.y[k] = d.centre.y, batch.z[k] = d.centre.z, batch.radius[k] = d.radius;
    batch.nx[k] = d.normal.x, batch.ny[k] = d.normal.y, batch.nz[k] = d.normal.z;
    batch.flatness[k] = d.flatness, batch.colour[k] = d.colour;
}

void put(TriangleBatch& batch, const Triangle& t) {
    const size_t k = size_t(batch.count++);
    for (int c = 0; c < 3; ++c) {
        batch.x[c][k] = t.corners[c].x, batch.y[c][k] = t.corners[c].y, batch.z[c][k] = t.corners[c].z;
        batch.nx[c][k] = t.normals[c].x, batch.ny[c][k] = t.normals[c].y, batch.nz[c][k] = t.normals[c].z;
    }
    batch.colour[k] = t.colour;
}

template <class Batch, class Item>
void add_all(render::SplatPainter& painter, const std::vector<Item>& items, size_t task, size_t task_count,
             int batch_size) {
    const auto batch = std::make_unique<Batch>();
    const size_t end = items.size() * (task + 1) / task_count;
    for (size_t i = items.size() * task / task_count; i < end; ++i) {
        put(*batch, items[i]);
        if (batch->count < batch_size && i + 1 < end) continue;
        painter.add(task, *batch);
        batch->count = 0;
    }
}

}  // namespace

geom::View view_of(int width, int height, double focal_px) {
    geom::View view;
    view.width = width, view.height = height, view.focal_px = focal_px;
    return view;
}

void add(render::SplatPainter& painter, const geom::View& view, const render::SplatterOptions& options,
         const Scene& scene, size_t task_count, int batch_size) {
    painter.begin(view, options, task_count);
    core::parallel_for(task_count, [&](size_t task) {
        add_all<SplatBatch>(painter, scene.discs, task, task_count, batch_size);
        add_all<TriangleBatch>(painter, scene.triangles, task, task_count, batch_size);
        painter.end_task(task);
    });
}

render::Frame draw(render::SplatPainter& painter, const geom::View& view,
                   const render::SplatterOptions& options, const Scene& scene, size_t task_count,
                   int batch_size) {
    add(painter, view, options, scene, task_count, batch_size);
    render::Frame frame;
    painter.finish(frame);
    return frame;
}

render::Frame draw(const geom::View& view, const render::SplatterOptions& options, const Scene& scene,
                   size_t task_count, int batch_size) {
    render::Splatter splatter;
    return draw(splatter, view, options, scene, task_count, batch_size);
}

std::vector<Triangle> triangles_of(const mesh::Mesh& mesh) {
    const std::vector<glm::vec3> normals = render::filled_normals(mesh);
    std::vector<Triangle> triangles;
    for (const glm::u32vec3& t : mesh.triangles) {
        Triangle& triangle = triangles.emplace_back();
        for (int k = 0; k < 3; ++k) {
            triangle.corners[k] = mesh.positions[t[k]];
            const glm::vec3& n = normals[t[k]];
            triangle.normals[k] = n == glm::vec3(0) ? glm::vec3(0, 0, -1) : glm::normalize(n);
        }
        if (mesh.colours.empty()) continue;
        const glm::u8vec3 c = mesh.colours[t[0]];
        triangle.colour = uint32_t(c.r) | uint32_t(c.g) << 8 | uint32_t(c.b) << 16;
    }
    return triangles;
}

Disc disc_of(const Triangle& t) {
    glm::dvec3 p[3] = {t.corners[0], t.corners[1], t.corners[2]};
    // The longest side last.
    for (int k = 0; k < 2; ++k)
        if (glm::distance(p[1], p[2]) > glm::distance(p[0], p[1])) std::rotate(p, p + 1, p + 3);
    if (glm::distance(p[0], p[2]) > glm::distance(p[0], p[1])) std::swap(p[1], p[2]);
    const glm::dvec3 a = p[0] - p[2], b = p[1] - p[2], cross = glm::cross(a, b);
    glm::dvec3 centre = 0.5 * (p[0] + p[1]);
    const double squares = glm::dot(cross, cross);
    if (glm::dot(a, b) > 0 && squares > 0)
        centre = p[2] + glm::cross(glm::dot(a, a) * b - glm::dot(b, b) * a, cross) / (2 * squares);
    double radius = 0;
    for (const glm::dvec3& corner : p) radius = std::max(radius, glm::distance(corner, centre));
    const glm::dvec3 facing = squares > 0 ? cross / std::sqrt(squares) : glm::dvec3(0, 0, 1);
    const double sense = glm::dot(facing, glm::dvec3(t.normals[0])) < 0 ? -1 : 1;
    return {glm::vec3(centre), float(1.001 * radius), glm::vec3(sense * facing), 0.02f, t.colour};
}

mesh::Mesh seen_from(mesh::Mesh mesh, const glm::dvec3& eye, const glm::dvec3& forward) {
    const glm::dvec3 f = glm::normalize(forward), r = glm::normalize(glm::cross(f, glm::dvec3(0.1, 1, 0.2)));
    const glm::dvec3 down = glm::cross(f, r);
    for (size_t v = 0; v < mesh.positions.size(); ++v) {
        const auto turned = [&](const glm::dvec3& p) {
            return glm::vec3(glm::dot(r, p), glm::dot(down, p), glm::dot(f, p));
        };
        mesh.positions[v] = turned(mesh.world(v) - eye);
        if (!mesh.normals.empty()) mesh.normals[v] = turned(mesh.normals[v]);
    }
    mesh.origin = {0, 0, 0};
    return mesh;
}

mesh::Mesh icosphere(int levels) {
    mesh::Mesh mesh;
    const float g = std::sqrt(1.25f) + 0.5f;
    for (const float s : {-1.0f, 1.0f})
        for (const float t : {-g, g})
            for (const glm::vec3& p : {glm::vec3(0, s, t), glm::vec3(s, t, 0), glm::vec3(t, 0, s)})
                mesh.positions.push_back(glm::normalize(p));
    const auto next = [&](size_t a, size_t b) {
        return glm::distance(mesh.positions[a], mesh.positions[b]) < 1.1f;
    };
    for (uint32_t a = 0; a < 12; ++a)
        for (uint32_t b = a + 1; b < 12; ++b)
            for (uint32_t c = b + 1; c < 12; ++c)
                if (next(a, b) && next(b, c) && next(c, a)) mesh.triangles.push_back({a, b, c});
    for (int level = 0; level < levels; ++level) {
        std::map<std::pair<uint32_t, uint32_t>, uint32_t> middles;
        std::vector<glm::u32vec3> finer;
        const auto middle = [&](uint32_t a, uint32_t b) {
            const auto [at, added] = middles.try_emplace(std::minmax(a, b), uint32_t(mesh.positions.size()));
            if (added) mesh.positions.push_back(glm::normalize(mesh.positions[a] + mesh.positions[b]));
            return at->second;
        };
        for (const glm::u32vec3& t : mesh.triangles) {
            const uint32_t ab = middle(t[0], t[1]), bc = middle(t[1], t[2]), ca = middle(t[2], t[0]);
            finer.insert(finer.end(), {{t[0], ab, ca}, {ab, t[1], bc}, {ca, bc, t[2]}, {ab, bc, ca}});
        }
        mesh.triangles = std::move(finer);
    }
    return mesh;
}

mesh::Mesh ball(int levels, const glm::vec3& middle, float radius) {
    mesh::Mesh mesh = icosphere(levels);
    mesh.normals = mesh.positions;
    for (glm::vec3& p : mesh.positions) p = middle + radius * p;
    return mesh;
}

mesh::Mesh sheet(int cells, float x0, float y0, float step, float z, float jitter, float roughness,
                 uint32_t seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> unit(-1, 1);
    mesh::Mesh mesh;
    const uint32_t row = uint32_t(cells) + 1;
    for (uint32_t j = 0; j < row; ++j) {
        for (uint32_t i = 0; i < row; ++i) {
            const bool is_rim = i == 0 || j == 0 || i + 1 == row || j + 1 == row;
            const float moved = is_rim ? 0 : jitter * step;
            mesh.positions.push_back({x0 + step * float(i) + moved * unit(random),
                                      y0 + step * float(j) + moved * unit(random),
                                      z + roughness * unit(random)});
        }
    }
    for (uint32_t j = 0; j + 1 < row; ++j) {
        for (uint32_t i = 0; i + 1 < row; ++i) {
            const uint32_t a = j * row + i, b = a + 1, c = a + row, d = c + 1;
            if (unit(random) < 0)
                mesh.triangles.insert(mesh.triangles.end(), {{a, c, b}, {d, b, c}});
            else
                mesh.triangles.insert(mesh.triangles.end(), {{b, a, d}, {a, c, d}});
        }
    }
    return mesh;
}

size_t covered(const render::Frame& frame) {
    return size_t(
        std::count_if(frame.depth.begin(), frame.depth.end(), [](float z) { return std::isfinite(z); }));
}

Difference difference(const render::Frame& a, const render::Frame& b, int levels) {
    Difference d;
    for (size_t i = 0; i < a.depth.size(); ++i) {
        if (std::isfinite(a.depth[i]) != std::isfinite(b.depth[i])) ++d.covered_apart;
        if (!std::isfinite(a.depth[i]) || !std::isfinite(b.depth[i])) continue;
        d.depth = std::max(d.depth, std::abs(double(a.depth[i]) / double(b.depth[i]) - 1));
        int most = 0;
        for (size_t k = 3 * i; k < 3 * i + 3; ++k) most = std::max(most, std::abs(a.rgb[k] - b.rgb[k]));
        d.turned += most > levels;
    }
    return d;
}

}  // namespace render_test
