// qs-build: turn a mesh or a cloud into a splat model, or compress one.  The work is mesh::read_mesh(),
// splat::build(), splat::write_compressed() and splat::write_plain().
#include <bit>
#include <set>

#include "core/error.h"
#include "core/file.h"
#include "core/program.h"
#include "core/stopwatch.h"
#include "core/words.h"
#include "mesh/mesh.h"
#include "mesh/read_report.h"
#include "splat/build.h"
#include "splat/compress.h"
#include "splat/info.h"
#include "splat/model.h"
#include "splat/qsplat_writer.h"

namespace {

core::Json report_of(const std::string& input, const mesh::ReadCounts& read, const splat::BuildReport& r,
                     double read_ms) {
    const splat::Header& h = r.header;
    auto dropped = read.vertices_dropped;
    for (const auto& [reason, count] : r.vertices_dropped) dropped[reason] += count;
    core::Json json = mesh::report_of(input, read, dropped);
    json["zero_area_faces"] = r.zero_area_faces;
    json["boundary_edges"] = r.boundary_edges;
    json["widest_gap"] = r.widest_gap;
    json["is_closed"] = (h.flags & splat::kOpenSurface) == 0;
    json["leaf"] = h.has_triangles() ? "triangle" : "point";
    if (h.has_triangles()) {
        json["triangles_acute"] = r.triangles.acute;
        json["triangles_right_or_obtuse"] = r.triangles.obtuse;
        json["triangles_degenerate"] = r.triangles.degenerate;
        json["triangles_flattened"] = r.triangles.flattened;
        json["triangles_smooth"] = r.triangles.smooth;
        json["vertices_merged"] = r.triangles.merged_vertices;
        json["lattice_bits"] = h.lattice_bits;
    }
    json["leaves"] = h.leaf_count;
    json["nodes"] = h.node_count;
    json["nodes_inserted"] = r.fit.inserted;
    json["levels"] = h.level_count;
    json["blocks"] = h.block_count;
    json["block_bytes"] = h.block_size;
    json["file_bytes"] = r.file_bytes;
    const double vertices = double(std::max<uint64_t>(h.vertices_in, 1));
    json["bytes_per_vertex"] = double(r.file_bytes) / vertices;
    if (h.has_triangles()) json["bytes_per_triangle"] = double(r.file_bytes) / double(h.leaf_count);
    core::Json channels;
    for (const splat::ChannelInfo& c : r.channels) channels[c.name] = double(c.bytes) / vertices;
    json["channel_bytes_per_vertex"] = channels;
    json["left_out"] = r.left_out;
    json["leaf_inflation_mean"] = r.fit.leaf_inflation / double(std::max<uint64_t>(r.fit.leaves, 1));
    json["leaf_inflation_max"] = r.fit.worst_leaf_inflation;
    json["inner_inflation_mean"] = r.fit.inner_inflation / double(std::max<uint64_t>(r.fit.inner, 1));
    json["open_fans"] = r.fit.open_fans;
    json["memory_estimate_bytes"] = r.memory_needed;
    core::Json stages;
    stages["read"] = read_ms;
    for (const auto& [stage, ms] : r.stage_ms) stages[stage] = ms;
    json["ms"] = stages;
    const splat::EncodeTimes& encode = r.fit.ms;
    json["encode_processor_ms"] = {{"surface", encode.surface},
                                   {"fit", encode.fit},
                                   {"leaf_errors", encode.leaf_errors},
                                   {"inner_errors", encode.inner_errors}};
    return json;
}

const char* kind_of(const splat::Header& h) {
    if (h.flags & splat::kCloud) return "a cloud";
    return h.flags & splat::kOpenSurface ? "an open surface: both sides are drawn"
                                         : "a closed surface: its back is culled";
}

// A model for the original QSplat program.
void write_qsplat(mesh::ReadResult&& read, const std::string& input, core::OutputFile& out, double read_ms,
                  core::Report& report) {
    core::Stopwatch watch;
    const mesh::ReadCounts& counts = read.counts;
    const splat::QsplatReport r = splat::write_qsplat(std::move(read.mesh), input, out);
    out.commit();
    auto dropped = counts.vertices_dropped;
    if (r.unreferenced) dropped["unreferenced"] += r.unreferenced;
    core::Json json = mesh::report_of(input, counts, dropped);
    json["leaves"] = r.leaves;
    json["nodes"] = r.nodes;
    json["levels"] = r.levels;
    json["file_bytes"] = r.file_bytes;
    json["bytes_per_vertex"] = double(r.file_bytes) / double(std::max<uint64_t>(counts.vertices_in, 1));
    json["leaf_inflation_mean"] = r.leaf_inflation_mean;
    json["leaf_inflation_max"] = r.leaf_inflation_max;
    json["ms"] = {{"read", read_ms}, {"write", watch.lap_ms()}};
    mesh::warn_of_drops(input, dropped, "vertices");
    mesh::warn_of_drops(input, counts.triangles_dropped, "triangles");
    report.write(json);
}

void warn_of_lattice(const std::string& input, const splat::BuildReport& r) {
    const auto number = [](uint64_t n) { return static_cast<unsigned long long>(n); };
    if (r.triangles.merged_vertices > 0)
        core::warn(core::text(
            "%s: %llu vertices are not told apart by a lattice of %u bits, %llu triangles lose their area",
            input.c_str(), number(r.triangles.merged_vertices), r.header.lattice_bits,
            number(r.triangles.flattened)));
}

splat::BuildReport build_with_progress(mesh::Mesh&& mesh, const splat::BuildOptions& options,
                                       core::OutputFile& out, const std::string& input) {
    core::Progress progress(
        "leaves", options.leaf == splat::Leaf::triangle ? mesh.triangles.size() : mesh.positions.size());
    return splat::build(std::move(mesh), options, out, input,
                        [&](uint64_t leaves) { progress.update(leaves); });
}

// Rewrites a model that is there, compressed or plain.
core::Json recode(core::InputFile file, const std::string& input, bool compress, core::OutputFile& out) {
    const splat::Model model(std::move(file));
    if (!model.is_complete())
        throw core::Error(core::text("%s: has %llu of %llu blocks, and only a whole model can be rewritten",
                                     model.name().c_str(),
                                     static_cast<unsigned long long>(model.blocks_present()),
                                     static_cast<unsigned long long>(model.header().block_count)));
    const splat::PlainModel plain = splat::plain_of(model);
    const uint64_t bytes =
        compress ? splat::write_compressed(plain, out).file_bytes : splat::write_plain(plain, out);
    out.commit();
    const double vertices = double(std::max<uint64_t>(model.header().vertices_in, 1));
    core::notice(core::text("%s: %llu bytes (%.2f a vertex), %.1f %% of the input's", out.name().c_str(),
                            static_cast<unsigned long long>(bytes), double(bytes) / vertices,
                            100.0 * double(bytes) / double(model.size_bytes())));
    return {{"input", input},
            {"format", "qs"},
            {"input_bytes", model.size_bytes()},
            {"is_compressed", compress},
            {"file_bytes", bytes},
            {"bytes_per_vertex", double(bytes) / vertices}};
}

}  // namespace

int main(int argc, char** argv) {
    core::Program program("qs-build", "Turn a mesh or a point cloud into a multiresolution splat model.",
                          QS_VERSION);
    std::string input, output, format = "qs";
    mesh::ReadOptions read_options;
    splat::BuildOptions build_options;
    uint64_t block_size = build_options.block_size;
    bool no_colour = false, plain = false;
    std::string leaf = "point";
    program.options
        .add_option("INPUT", input,
                    "PLY, OBJ, OFF, STL, Draco or QSplat file, or a model; - is a PLY on standard input")
        ->required();
    program.options.add_option("-o,--output", output, "Model to write; - is standard output")->required();
    program.options.add_option("--format", format, "qs, or qsplat11 for the original QSplat program")
        ->check(core::one_of({"qs", "qsplat11"}))
        ->type_name("FORMAT")
        ->capture_default_str();
    program.options.add_option("--leaf", leaf, "What leaves are")
        ->check(core::one_of({"point", "triangle"}))
        ->type_name("point|triangle")
        ->capture_default_str();
    program.add_size("--block-size", block_size, "Bytes a block, a power of two from 1K to 64K");
    program.add_size("--memory", build_options.memory_limit,
                     "Refuse what would need more memory than this; 0 is no limit");
    program.options.add_flag("--skip-bad", read_options.skip_bad,
                             "Drop vertices that are not finite, and their faces");
    program.options.add_flag("--no-colour", no_colour, "Leave colours out");
    auto* compress = program.options.add_flag("--compress", build_options.compress,
                                              "Code blocks; INPUT may be a model, and is then rewritten");
    program.options
        .add_flag("--plain", plain, "Rewrite a model without coding: the same bytes as before --compress")
        ->excludes(compress);

    const std::set<std::string> of_meshes{"--block-size", "--memory", "--skip-bad",
                                          "--no-colour",  "--format", "--leaf"};

    return program.run(argc, argv, [&] {
        if (block_size < splat::kMinBlockSize || block_size > splat::kMaxBlockSize ||
            !std::has_single_bit(block_size))
            throw core::UsageError(core::text("--block-size: %llu is not a power of two from 1K to 64K",
                                              static_cast<unsigned long long>(block_size)));
        const bool is_for_qsplat = format == "qsplat11";
        if (is_for_qsplat && (block_size != build_options.block_size || build_options.memory_limit > 0))
            throw core::UsageError("--format qsplat11: has no blocks and keeps to no --memory");
        if (is_for_qsplat && leaf == "triangle")
            throw core::UsageError("--format qsplat11: has no triangles");
        if (core::same_file(input, output)) throw core::UsageError(output + ": is input and output at once");
        build_options.block_size = uint32_t(block_size);
        build_options.keep_colour = !no_colour;
        build_options.leaf = leaf == "triangle" ? splat::Leaf::triangle : splat::Leaf::point;
        if (is_for_qsplat && build_options.compress)
            throw core::UsageError("--format qsplat11: has no blocks that --compress could code");
        core::Report report({input}, {output});
        core::OutputFile out(output);
        core::Stopwatch watch;
        core::InputFile file(input);  // once: it may be a pipe
        if (plain || splat::is_model(file.bytes())) {
            if (!plain && !build_options.compress)
                throw core::UsageError(input + ": is a model already; --compress or --plain rewrites it");
            for (const CLI::Option* option :
                 program.options.get_options([](const CLI::Option* o) { return o->count() > 0; }))
                if (of_meshes.contains(option->get_name()))
                    throw core::UsageError(option->get_name() +
                                           ": is for a mesh or a cloud, not for a model");
            report.write(recode(std::move(file), input, build_options.compress, out));
            return report.commit();
        }
        mesh::ReadResult read = mesh::read_mesh(std::move(file), read_options);
        const double read_ms = watch.lap_ms();
        if (is_for_qsplat) {
            if (no_colour) read.mesh.colours.clear();
            write_qsplat(std::move(read), input, out, read_ms, report);
            return report.commit();
        }
        const splat::BuildReport built = build_with_progress(std::move(read.mesh), build_options, out, input);
        out.commit();
        mesh::warn_of_drops(input, read.counts.vertices_dropped, "vertices");
        mesh::warn_of_drops(input, built.vertices_dropped, "vertices");
        mesh::warn_of_drops(input, read.counts.triangles_dropped, "triangles");
        warn_of_lattice(input, built);
        core::notice(core::text(
            "%s: %llu %s in %llu bytes (%.2f a %s), %u levels, %s", output.c_str(),
            static_cast<unsigned long long>(built.header.leaf_count),
            leaf == "triangle" ? "triangles" : "vertices", static_cast<unsigned long long>(built.file_bytes),
            double(built.file_bytes) / double(built.header.leaf_count),
            leaf == "triangle" ? "triangle" : "vertex", built.header.level_count, kind_of(built.header)));
        report.write(report_of(input, read.counts, built, read_ms));
        report.commit();
    });
}
