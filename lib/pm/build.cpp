#include "pm/build.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/parallel.h"
#include "core/stopwatch.h"
#include "pm/build/details.h"
#include "pm/build/locality.h"
#include "pm/build/manifold.h"
#include "pm/build/simplify.h"
#include "pm/build/writer.h"
#include "pm/model.h"

namespace pm {

namespace {

constexpr double kOpenGap =
    0.1;  // widest boundary, in radii, of a model still taken as closed; as of splat models
constexpr size_t kGrain = 4096;

class Builder {
  public:
    Builder(mesh::Mesh&& mesh, const BuildOptions& options, const std::string& name, BuildReport& report)
        : mesh_(std::move(mesh)), options_(options), name_(name), report_(report) {}

    void run(core::OutputFile& out, const std::function<void(uint64_t)>& progress) {
        check_size();
        set_header();
        if (options_.with_normals) set_normals();
        surface_ = make_manifold(mesh_.triangles, mesh_.positions);
        mesh_.triangles = std::vector<glm::u32vec3>();  // braces would keep its memory
        lap("clean");
        set_placement();
        set_positions();
        sort_by_place(surface_, positions_);
        set_positions();
        judge_surface();
        lap("round");
        SimplifyResult simplified = simplify(positions_, surface_.faces, {options_.flip_test}, progress);
        report_.passes = simplified.passes;
        report_.refused_links = simplified.refused_links, report_.refused_flips = simplified.refused_flips;
        watch_.lap_ms();
        report_.stage_ms.emplace_back("collapse", simplified.collapse_ms);
        report_.stage_ms.emplace_back("support", simplified.support_ms);
        const Details details =
            make_details(positions_, surface_.faces, std::move(simplified), header().flags & kOpenSurface);
        count(details);
        surface_.faces = std::vector<glm::u32vec3>();
        lap("order");
        write_model(header(), details, vertex_data(details), welds(details), out);
        report_.file_bytes = Layout(header()).end;
        lap("write");
    }

  private:
    Header& header() { return report_.header; }
    void lap(const char* stage) { report_.stage_ms.emplace_back(stage, watch_.lap_ms()); }

    void check_size() const {
        if (mesh_.triangles.empty())
            throw core::Error(name_ + ": has no faces, and a progressive mesh is made of triangles");
        // Every corner may become a vertex.
        if (mesh_.triangles.size() > kMostVertices / 3)
            throw core::Error(core::text("%s: %zu triangles, at most %u are possible", name_.c_str(),
                                         mesh_.triangles.size(), kMostVertices / 3));
    }

    void set_header() {
        Header& h = header();
        h.bits = options_.bits;
        h.vertices_in = mesh_.positions.size();
        h.triangles_in = mesh_.triangles.size();
        if (mesh_.colours.empty())
            report_.left_out.emplace_back("colour: the input has none");
        else if (!options_.keep_colours)
            report_.left_out.emplace_back("colour: not wanted");
        else
            h.flags |= kHasColours;
        if (options_.with_normals)
            h.flags |= kHasNormals;
        else
            report_.left_out.emplace_back("normals: not wanted");
    }

    // Weighted by area, where the input has none.
    void set_normals() {
        if (!mesh_.normals.empty()) return;
        std::vector<glm::dvec3> sum(mesh_.positions.size(), glm::dvec3(0));
        for (const glm::u32vec3& t : mesh_.triangles) {
            const glm::dvec3 a(mesh_.positions[t.x]), b(mesh_.positions[t.y]), c(mesh_.positions[t.z]);
            const glm::dvec3 normal = glm::cross(b - a, c - a);
            for (int k = 0; k < 3; ++k) sum[t[k]] += normal;
        }
        mesh_.normals.resize(sum.size());
        for (size_t v = 0; v < sum.size(); ++v) {
            const double largest = std::max({std::fabs(sum[v].x), std::fabs(sum[v].y), std::fabs(sum[v].z)});
            mesh_.normals[v] = largest > 0 ? glm::vec3(glm::normalize(sum[v] / largest)) : glm::vec3(0);
        }
    }

    void set_placement() {
        glm::dvec3 low(mesh_.positions[surface_.source[0]]), high = low;
        for (const uint32_t v : surface_.source)
            low = glm::min(low, glm::dvec3(mesh_.positions[v])),
            high = glm::max(high, glm::dvec3(mesh_.positions[v]));
        const glm::dvec3 size = high - low;
        const double extent = std::max({size.x, size.y, size.z});
        header().placement = {mesh_.origin, low, extent > 0 ? extent : 1};
    }

    void set_positions() {
        const size_t count = surface_.source.size();
        positions_.resize(count);
        core::parallel_for(
            count,
            [&](size_t v) {
                const uint32_t source = surface_.source[v];
                positions_[v] = header().is_lossless() ? unit_from_single(mesh_.positions[source], header())
                                                       : unit_from_lattice(lattice(source), header());
            },
            kGrain);
    }

    // Of a vertex of the input.
    glm::u32vec3 lattice(uint32_t source) const {
        const Placement& at = report_.header.placement;
        const glm::dvec3 unit = (glm::dvec3(mesh_.positions[source]) - at.low) / at.extent;
        return glm::u32vec3(glm::floor(unit * report_.header.steps() + 0.5));
    }

    void judge_surface() {
        report_.unreferenced = surface_.unreferenced;
        report_.duplicate_faces = surface_.duplicate_faces;
        report_.cut_edges = surface_.cut_edges;
        report_.boundary_edges = surface_.boundary.size();
        const auto has_area = [](const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
            return glm::cross(b - a, c - a) != glm::dvec3(0);
        };
        for (const glm::u32vec3& f : surface_.faces) {
            if (has_area(positions_[f.x], positions_[f.y], positions_[f.z])) continue;
            ++report_.zero_area_faces;
            const auto unit = [&](uint32_t v) {
                return unit_from_single(mesh_.positions[surface_.source[v]], header());
            };
            report_.flattened_faces += has_area(unit(f.x), unit(f.y), unit(f.z));
        }
        glm::dvec3 high(0);
        for (const glm::dvec3& p : positions_) high = glm::max(high, p);
        const double radius = 0.5 * glm::length(high);
        if (radius > 0) report_.widest_gap = widest_gap(surface_, positions_) / radius;
        if (report_.widest_gap > kOpenGap) {
            header().flags |= kOpenSurface;
            report_.left_out.emplace_back("cones: the surface is open, and both sides may be seen");
        }
    }

    void count(const Details& details) {
        Header& h = header();
        h.base_vertices = details.base_vertices;
        h.base_faces = uint32_t(details.base_faces.size());
        h.details = details.count();
        h.depth = details.depth;
        h.faces = surface_.faces.size();
        h.welds = uint32_t(surface_.welds.size());
        report_.dependencies = uint64_t(
            std::count_if(details.needs.begin(), details.needs.end(), [](uint32_t d) { return d != kNone; }));
    }

    VertexData vertex_data(const Details& details) const {
        VertexData data;
        for (const uint32_t v : details.vertex) {
            const uint32_t source = surface_.source[v];
            if (report_.header.is_lossless())
                data.single.push_back(mesh_.positions[source]);
            else
                data.lattice.push_back(lattice(source));
            if (report_.header.has_normals())
                data.normals.push_back(encode_normal(glm::dvec3(mesh_.normals[source])));
            if (report_.header.has_colours()) data.colours.push_back(mesh_.colours[source]);
        }
        return data;
    }

    std::vector<Weld> welds(const Details& details) const {
        std::vector<uint32_t> number(details.vertex.size());
        for (uint32_t v = 0; v < number.size(); ++v) number[details.vertex[v]] = v;
        std::vector<Weld> welds;
        for (const Weld& weld : surface_.welds) welds.push_back({number[weld.copy], number[weld.of]});
        return welds;
    }

    mesh::Mesh mesh_;
    const BuildOptions& options_;
    const std::string& name_;
    BuildReport& report_;
    core::Stopwatch watch_;
    Manifold surface_;
    std::vector<glm::dvec3> positions_;  // unit space, rounded
};

}  // namespace

BuildReport build(mesh::Mesh&& mesh, const BuildOptions& options, core::OutputFile& out,
                  const std::string& name, const std::function<void(uint64_t)>& progress) {
    BuildReport report;
    Builder(std::move(mesh), options, name, report).run(out, progress);
    return report;
}

}  // namespace pm
