// qs-info: say what models hold, verify them, take a level out.  The work is splat::read_info(),
// splat::verify(), splat::write_cut(), and of progressive meshes pm::read_info() and pm::verify().
#include "core/error.h"
#include "core/file.h"
#include "core/program.h"
#include "pm/info.h"
#include "pm/verify.h"
#include "scene/model_beginning.h"
#include "scene/remote_models.h"
#include "splat/extract.h"
#include "splat/info.h"
#include "splat/qsplat_info.h"
#include "splat/verify.h"

namespace {

struct Options {
    std::vector<std::string> models;
    bool json = false, verify = false;
    int64_t level = -1;
    std::string output, cache;
};

core::Json to_json(const std::string& name, const splat::VerifyCounts& counts) {
    return {{"file", name},          {"is_whole", true},        {"blocks", counts.blocks},
            {"nodes", counts.nodes}, {"leaves", counts.leaves}, {"level_count", counts.levels}};
}

bool is_qsplat(const core::InputFile& file) {
    return mesh::is_qsplat({file.bytes(), file.name()});
}

// Reading all of such a file is all there is to verify: it has no checksums.
std::string inspect_qsplat(const core::InputFile& file, const Options& o, core::Report& report) {
    const splat::QsplatInfo info = splat::read_qsplat_info(file);
    core::Json json = splat::to_json(info);
    if (o.verify)
        json = {{"file", info.name},
                {"is_whole", true},
                {"nodes", info.nodes},
                {"leaves", info.leaves},
                {"level_count", info.levels.size() - 1}};
    report.write(json);
    if (o.json) return json.dump() + "\n";
    if (!o.verify) return splat::to_text(info);
    return info.name + core::text(": whole, without checksums: %llu nodes, %llu leaves, %zu levels\n",
                                  static_cast<unsigned long long>(info.nodes),
                                  static_cast<unsigned long long>(info.leaves), info.levels.size() - 1);
}

std::string inspect_mesh(core::InputFile file, const Options& o, core::Report& report) {
    const pm::Model model(std::move(file));
    if (!o.verify) {
        const pm::Info info = pm::read_info(model);
        const core::Json json = pm::to_json(info);
        report.write(json);
        return o.json ? json.dump() + "\n" : pm::to_text(info);
    }
    const pm::VerifyCounts c = pm::verify(model);
    const core::Json json = {{"file", model.name()},   {"is_whole", true},
                             {"vertices", c.vertices}, {"faces", c.faces},
                             {"details", c.details},   {"dependencies", c.dependencies}};
    report.write(json);
    if (o.json) return json.dump() + "\n";
    const auto number = [](uint64_t n) { return static_cast<unsigned long long>(n); };
    return model.name() + core::text(": whole: %llu vertices, %llu faces, %llu splits\n", number(c.vertices),
                                     number(c.faces), number(c.details));
}

std::string verify(core::InputFile file, const Options& o, core::Report& report) {
    const std::string name = file.name();
    const splat::VerifyCounts c = splat::verify(std::move(file));
    const core::Json json = to_json(name, c);
    report.write(json);
    if (o.json) return json.dump() + "\n";
    const auto number = [](uint64_t n) { return static_cast<unsigned long long>(n); };
    return name + core::text(": whole: %llu blocks, %llu nodes, %llu leaves, %u levels\n", number(c.blocks),
                             number(c.nodes), number(c.leaves), c.levels);
}

std::string describe(core::InputFile file, const Options& o, core::Report& report) {
    const splat::Info info = splat::read_info(splat::Model(std::move(file)));
    const core::Json json = splat::to_json(info);
    report.write(json);
    return o.json ? json.dump() + "\n" : splat::to_text(info);
}

// Of what is read from a pipe, see core::InputFile.  Progressive meshes and models of the original program
// end where they end.
uint64_t size_limit(std::span<const std::byte> head, const std::string& name) {
    if (mesh::is_qsplat({head, name}) || pm::is_model(head)) return UINT64_MAX;
    return splat::file_bytes(head, name);
}

std::string inspect(const std::string& path, const Options& o, core::Report& report) {
    core::InputFile file =
        scene::is_url(path) ? scene::open_beginning(path, o.cache) : core::InputFile(path, size_limit);
    if (is_qsplat(file)) return inspect_qsplat(file, o, report);
    if (pm::is_model(file.bytes())) return inspect_mesh(std::move(file), o, report);
    return o.verify ? verify(std::move(file), o, report) : describe(std::move(file), o, report);
}

// Returns what it wrote, as the report has it.
core::Json write_cut(core::InputFile file, uint32_t level, core::OutputFile& out) {
    if (is_qsplat(file)) return {{"points", splat::write_qsplat_cut(file, level, out)}};
    const splat::CutWritten written = splat::write_cut(splat::Model(std::move(file)), level, out);
    if (written.triangles > 0) return {{"triangles", written.triangles}};
    return {{"points", written.points}};
}

void cut(const std::string& path, const Options& o, core::Report& report) {
    core::refuse_binary_to_terminal(!o.output.empty());
    const std::string output = o.output.empty() ? "-" : o.output;
    if (core::same_file(path, output)) throw core::UsageError(output + ": is input and output at once");
    core::InputFile file(path, size_limit);
    const std::string name = file.name();
    if (pm::is_model(file.bytes()))
        throw core::UsageError(name +
                               ": is a progressive mesh, which pm-build --level takes resolutions out of");
    core::OutputFile out(output);
    core::Json json = {{"file", name}, {"level", o.level}};
    json.update(write_cut(std::move(file), uint32_t(o.level), out));
    out.commit();
    report.write(json);
}

// A model that fails is reported and left out.
void inspect_all(const Options& o, core::Report& report) {
    bool has_printed = false;
    for (const std::string& path : o.models) {
        try {
            const std::string text = inspect(path, o, report);
            const bool are_apart = has_printed && !o.json && !o.verify;
            if (!report.is_standard_output()) core::print(are_apart ? "\n" + text : text);
            has_printed = true;
        } catch (const core::Error& error) {
            core::fail(error.what());
        }
    }
}

// Of a URL only the beginning is fetched.
void refuse_urls(const Options& o, const std::string& option) {
    for (const std::string& model : o.models)
        if (scene::is_url(model))
            throw core::UsageError(option + ": " + model + ": needs the file; 'qs-fetch get' brings it");
}

void run(const Options& o) {
    const bool wants_cut = o.level >= 0;
    if (wants_cut || o.verify) refuse_urls(o, wants_cut ? "--cut" : "--verify");
    if (wants_cut && (o.verify || o.json))
        throw core::UsageError(std::string("--cut and ") + (o.verify ? "--verify" : "--json") +
                               " exclude each other");
    if (wants_cut && o.models.size() > 1) throw core::UsageError("--cut: takes one model, not several");
    if (!wants_cut && !o.output.empty()) throw core::UsageError("--output: needs --cut");
    core::Report report(o.models, {wants_cut && o.output.empty() ? "-" : o.output});
    if (wants_cut)
        cut(o.models.front(), o, report);
    else
        inspect_all(o, report);
    report.commit();
}

}  // namespace

int main(int argc, char** argv) {
    core::Program program("qs-info", "Say what splat models hold, verify them, or take a level out.",
                          QS_VERSION);
    Options o;
    program.options
        .add_option("MODEL", o.models, "Splat models, the first bytes of them, or URLs; - is standard input")
        ->required();
    program.options.add_flag("--json", o.json, "Print JSON, one object a model, keys as in qs-info(1)");
    program.options.add_flag("--verify", o.verify,
                             "Check every checksum and invariant; the first fault is named");
    core::add_integer(program.options, "--cut", o.level, 0, splat::kMaxLevels,
                      "Write the nodes of this level as points, or the triangles")
        ->type_name("LEVEL")
        ->default_str("");
    program.options.add_option("-o,--output", o.output, "PLY file to write with --cut; - is standard output")
        ->type_name("FILE");
    program.options.add_option("--cache", o.cache, "Folder of qs-fetch's cache")->type_name("DIR");
    return program.run(argc, argv, [&] { run(o); });
}
