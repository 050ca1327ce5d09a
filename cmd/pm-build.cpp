// pm-build: turn a mesh into a progressive mesh, or write a resolution of one.  The work is
// mesh::read_mesh(), pm::build() and pm::mesh_of_level().
#include <charconv>
#include <cmath>
#include <optional>
#include <set>

#include "core/error.h"
#include "core/file.h"
#include "core/program.h"
#include "core/stopwatch.h"
#include "mesh/mesh.h"
#include "mesh/read_report.h"
#include "pm/build.h"
#include "pm/extract.h"
#include "pm/model.h"

namespace {

unsigned long long number(uint64_t value) {
    return static_cast<unsigned long long>(value);
}

core::Json report_of(const std::string& input, const mesh::ReadCounts& read, const pm::BuildReport& r,
                     double read_ms) {
    const pm::Header& h = r.header;
    core::Json json = mesh::report_of(input, read, read.vertices_dropped);
    json["zero_area_faces"] = r.zero_area_faces;
    json["flattened_faces"] = r.flattened_faces;
    json["cut_edges"] = r.cut_edges;
    json["cut_vertices"] = h.welds;
    json["boundary_edges"] = r.boundary_edges;
    json["widest_gap"] = r.widest_gap;
    json["is_closed"] = (h.flags & pm::kOpenSurface) == 0;
    json["bits"] = h.bits;
    json["vertices"] = h.vertices();
    json["faces"] = h.faces;
    json["base_vertices"] = h.base_vertices;
    json["base_faces"] = h.base_faces;
    json["details"] = h.details;
    json["depth"] = h.depth;
    json["dependencies"] = r.dependencies;
    json["passes"] = r.passes;
    json["refused_links"] = r.refused_links;
    json["refused_flips"] = r.refused_flips;
    json["file_bytes"] = r.file_bytes;
    json["bytes_per_vertex"] = double(r.file_bytes) / double(h.vertices());
    json["left_out"] = r.left_out;
    core::Json stages;
    stages["read"] = read_ms;
    for (const auto& [stage, ms] : r.stage_ms) stages[stage] = ms;
    json["ms"] = stages;
    return json;
}

void warn_of(const std::string& input, uint64_t count, const char* what) {
    if (count > 0) core::warn(core::text("%s: %llu %s", input.c_str(), number(count), what));
}

// "full", a number of splits, or a share of them: "5%".
struct Level {
    std::optional<double> share;
    uint64_t splits = 0;

    uint32_t of(const pm::Model& model) const {
        if (share) return uint32_t(std::floor(*share * double(model.details()) + 0.5));
        if (splits > model.details())
            throw core::Error(core::text("%s: has %u splits, --level asks for %llu", model.name().c_str(),
                                         model.details(), number(splits)));
        return uint32_t(splits);
    }
};

Level parse_level(const std::string& text) {
    if (text == "full") return {1.0, 0};
    const char* const end = text.data() + text.size();
    Level level;
    if (text.ends_with('%')) {
        double percent = 0;
        const auto [at, error] = std::from_chars(text.data(), end, percent, std::chars_format::fixed);
        if (error == std::errc() && at == end - 1 && percent >= 0 && percent <= 100)
            return {percent / 100, 0};
    } else if (const auto [at, error] = std::from_chars(text.data(), end, level.splits);
               error == std::errc() && at == end) {
        return level;
    }
    throw core::UsageError("--level: '" + text + "' is not a number of splits, a share such as 5%, or full");
}

core::Json write_level(core::InputFile file, const std::string& input, const Level& level,
                       core::OutputFile& out) {
    const pm::Model model(std::move(file));
    const uint32_t splits = level.of(model);
    const mesh::Mesh mesh = pm::mesh_of_level(model, splits);
    out.write(mesh::to_ply(mesh));
    out.commit();
    return {{"input", input},
            {"format", "pm"},
            {"splits", splits},
            {"vertices", mesh.positions.size()},
            {"faces", mesh.triangles.size()}};
}

core::Json build(core::InputFile file, const std::string& input, const mesh::ReadOptions& read_options,
                 const pm::BuildOptions& options, core::OutputFile& out) {
    core::Stopwatch watch;
    const std::string name = file.name();
    mesh::ReadResult read = mesh::read_mesh(std::move(file), read_options);
    const double read_ms = watch.lap_ms();
    pm::BuildReport built;
    {
        core::Progress progress("collapses", 0);
        built = pm::build(std::move(read.mesh), options, out, name,
                          [&](uint64_t done) { progress.update(done); });
    }
    out.commit();
    if (built.unreferenced > 0) read.counts.vertices_dropped["unreferenced"] += built.unreferenced;
    if (built.duplicate_faces > 0) read.counts.triangles_dropped["duplicate"] += built.duplicate_faces;
    mesh::warn_of_drops(name, read.counts.vertices_dropped, "vertices");
    mesh::warn_of_drops(name, read.counts.triangles_dropped, "triangles");
    warn_of(name, built.cut_edges,
            "edges are not of two faces that run against each other, and were cut or paired");
    warn_of(name, built.flattened_faces,
            "faces are kept but have no area on the lattice, and are not seen; --bits makes it finer");
    const pm::Header& h = built.header;
    core::notice(core::text("%s: %u splits from %u vertices, %u faces; %llu bytes (%.2f a vertex)",
                            out.name().c_str(), h.details, h.base_vertices, h.base_faces,
                            number(built.file_bytes), double(built.file_bytes) / double(h.vertices())));
    return report_of(input, read.counts, built, read_ms);
}

}  // namespace

int main(int argc, char** argv) {
    core::Program program("pm-build", "Turn a mesh into a progressive mesh, or write a resolution of one.",
                          QS_VERSION);
    std::string input, output, level_text;
    mesh::ReadOptions read_options;
    pm::BuildOptions options;
    int64_t bits = options.bits;
    bool is_lossless = false, no_colour = false, no_flip_test = false;
    program.options
        .add_option(
            "INPUT", input,
            "PLY, OBJ, OFF, STL or Draco mesh, or with --level a progressive mesh; - is standard input")
        ->required();
    program.options
        .add_option("-o,--output", output,
                    "Progressive mesh to write, with --level a PLY; - is standard output")
        ->required();
    auto* with_bits = program.add_integer("--bits", bits, pm::kMinBits, pm::kMaxBits,
                                          "Bits a coordinate along the longest side");
    auto* lossless =
        program.options
            .add_flag("--lossless", is_lossless, "Coordinates as in the input, in single precision")
            ->excludes(with_bits);
    auto* colour = program.options.add_flag("--no-colour", no_colour, "Leave colours out");
    auto* normals = program.options.add_flag("--normals", options.with_normals,
                                             "Keep normals, or make them where there are none");
    auto* flips =
        program.options.add_flag("--no-flip-test", no_flip_test, "Allow collapses that turn faces over");
    auto* skip = program.options.add_flag("--skip-bad", read_options.skip_bad,
                                          "Drop vertices that are not finite, and their faces");
    auto* level = program.options.add_option(
        "--level", level_text,
        "Write this resolution of a model as PLY: splits, a share such as 5%, or full");
    level->type_name("LEVEL");
    for (CLI::Option* of_builds : {with_bits, lossless, colour, normals, flips, skip})
        level->excludes(of_builds);

    return program.run(argc, argv, [&] {
        if (core::same_file(input, output)) throw core::UsageError(output + ": is input and output at once");
        const Level wanted = level->count() > 0 ? parse_level(level_text) : Level{};
        options.bits = is_lossless ? 0 : uint32_t(bits);
        options.keep_colours = !no_colour;
        options.flip_test = !no_flip_test;
        core::Report report({input}, {output});
        core::OutputFile out(output);
        core::InputFile file(input);  // once: it may be a pipe
        if (level->count() > 0)
            report.write(write_level(std::move(file), input, wanted, out));
        else if (pm::is_model(file.bytes()))
            throw core::UsageError(input +
                                   ": is a progressive mesh already; --level writes a resolution of it");
        else
            report.write(build(std::move(file), input, read_options, options, out));
        report.commit();
    });
}
