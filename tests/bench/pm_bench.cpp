// pm_bench: what streaming a progressive mesh costs, counted in one process: bytes as they would go over a
// connection, frames of the protocol included, and memory of the server.
//
//     pm_bench session MODEL.pm PATH.jsonl W,H THRESHOLD THRESHOLD2
//     pm_bench bytes MODEL.pm PATH.jsonl W,H THRESHOLD...
//     pm_bench budget MODEL.pm PATH.jsonl W,H BYTES FOLDER
//
// `session` follows a path, from its middle on by the second threshold, and says after each camera what the
// server keeps: as sent bits, as the paper's window of active tags, and as its list of a vertex front.
// `bytes` says for each camera and threshold, in pixels, what it takes to satisfy it: by views, one way, and
// by the shortest part of streams that do not depend on views and hold what the view wants.
// `budget` writes to FOLDER the meshes that a client has for the path's first camera after so many bytes.
//
// Each line of output is a JSON object.
#include <algorithm>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <functional>
#include <numeric>

#include "core/error.h"
#include "core/file.h"
#include "core/program.h"
#include "geom/camera.h"
#include "mesh/mesh.h"
#include "pm/answer.h"
#include "pm/extract.h"
#include "pm/one_way.h"
#include "pm/selection.h"

namespace {

constexpr uint32_t kDecisions = 512;
constexpr size_t kPacketOverhead = 4 + 9;  // frame and message, beside the coded decisions
constexpr size_t kOpenedOverhead = 4 + 3 + pm::kHeaderSize;
constexpr size_t kPaperBytesOfNode = 12;   // of its vertex front
constexpr size_t kPaperBytesOfSplit = 24;  // of its view-independent stream

struct Scene {
    pm::ServedModel served;
    std::vector<geom::Camera> cameras;
    int width = 0, height = 0;

    Scene(const char* model, const char* path, const char* size) : served(pm::Model(model)) {
        const core::InputFile file(path);
        cameras = geom::parse_path({reinterpret_cast<const char*>(file.bytes().data()), file.bytes().size()},
                                   file.name());
        if (std::sscanf(size, "%d,%d", &width, &height) != 2) throw core::UsageError("W,H: are two numbers");
    }
    pm::View view(const geom::Camera& camera, double threshold_px) const {
        return pm::make_view(geom::make_view(camera, width, height), threshold_px);
    }
};

// A server's side of a connection; what goes over it depends on nothing else.
struct Link {
    const pm::ServedModel& served;
    pm::SentRecord record;
    size_t bytes;

    Link(const pm::ServedModel& model, pm::Service service)
        : served(model), record(service), bytes(kOpenedOverhead + model.base_packet(service).size()) {}

    // Until the view is satisfied, or so many bytes are reached.
    void answer(const pm::View& view, pm::Culling culling, size_t most_bytes = SIZE_MAX) {
        std::unique_ptr<pm::PacketSource> source;
        if (record.service == pm::Service::one_way)
            source = std::make_unique<pm::OneWayAnswer>(served, record, view, culling);
        else
            source = std::make_unique<pm::Answer>(served, record, view, culling);
        for (bool is_last = false; !is_last && bytes < most_bytes;) {
            const pm::Packet packet = source->next(kDecisions);
            bytes += kPacketOverhead + packet.bytes.size();
            is_last = packet.is_last;
        }
    }
    mesh::Mesh mesh() const {
        pm::Front front(served.model().hierarchy());
        record.for_each([&](uint32_t detail) { front.split(detail); });
        return pm::mesh_of(served.model(), front);
    }
};

// From so far that the distance is the same everywhere: what is wanted is what has this error.
pm::View far_view(const pm::ServedModel& served, double error) {
    constexpr double kFar = 1e7;
    const pm::Placement& at = served.model().header().placement;
    pm::View view;
    view.eye = at.world_from_unit(glm::dvec3(0.5, 0.5, -kFar));
    view.tolerance = error / kFar;
    return view;
}

// The details in the order of decimation by levels: those of the highest subtrees first.
std::vector<uint32_t> level_order(const pm::Model& model) {
    const auto children = model.children();
    std::vector<uint32_t> height(model.details(), 1), order(model.details());
    for (uint32_t d = model.details(); d-- > 0;)
        for (const uint32_t child : {children[d].kept, children[d].fresh})
            if (child != pm::kNone) height[d] = std::max(height[d], height[child] + 1);
    std::iota(order.begin(), order.end(), 0u);
    std::stable_sort(order.begin(), order.end(),
                     [&](uint32_t a, uint32_t b) { return height[a] > height[b]; });
    return order;
}

// ---- memory ----

// The paper's active tags: a bit a node, nodes in breadth-first order.
class ActiveTags {
  public:
    explicit ActiveTags(const pm::Model& model) : model_(model), kept_(model.details()) {
        const auto roots = model.root_split();
        split_by_.assign(roots.begin(), roots.end());
        for (uint32_t n = 0; n != split_by_.size(); ++n) {
            const uint32_t d = split_by_[n];
            if (d == pm::kNone) continue;
            kept_[d] = uint32_t(split_by_.size());
            split_by_.push_back(model.children()[d].kept);
            split_by_.push_back(model.children()[d].fresh);
        }
        is_below_.resize(split_by_.size());
    }
    struct Memory {
        size_t active = 0, window = 0, allocated = 0;
    };
    Memory measure(const pm::SentRecord& record) {
        std::fill(is_below_.begin(), is_below_.end(), uint8_t(0));
        size_t first = SIZE_MAX, last = 0;
        Memory memory;
        for (uint32_t n = 0; n != split_by_.size(); ++n) {
            const bool is_there = n < model_.root_split().size() || is_below_[n] != 0;
            const uint32_t d = split_by_[n];
            const bool is_split = is_there && d != pm::kNone && record.is_sent(d);
            if (is_split) is_below_[kept_[d]] = is_below_[kept_[d] + 1] = 1;
            if (!is_there || is_split) continue;
            ++memory.active;
            first = std::min<size_t>(first, n), last = n;
        }
        memory.window = (last - first) / 8 + 1;
        while (allocated_ < memory.window) allocated_ *= 2;
        memory.allocated = allocated_;
        return memory;
    }
    size_t nodes() const { return split_by_.size(); }

  private:
    const pm::Model& model_;
    std::vector<uint32_t> kept_, split_by_;  // by detail: its kept child; by node: the detail
    std::vector<uint8_t> is_below_;
    size_t allocated_ = 256;  // doubled when it is too small, as the paper's
};

void follow_session(const Scene& scene, double threshold_px, double second_px) {
    Link link(scene.served, pm::Service::selective);
    ActiveTags tags(scene.served.model());
    for (size_t i = 0; i != scene.cameras.size(); ++i) {
        const double px = 2 * i < scene.cameras.size() ? threshold_px : second_px;
        link.answer(scene.view(scene.cameras[i], px), pm::Culling::on);
        const ActiveTags::Memory memory = tags.measure(link.record);
        core::print(core::Json{{"frame", i},
                               {"threshold_px", px},
                               {"splits_sent", link.record.count()},
                               {"sent_bits_bytes", link.record.bits_bytes()},
                               {"window_bytes", memory.window},
                               {"window_allocated_bytes", memory.allocated},
                               {"front_bytes", memory.active * kPaperBytesOfNode + tags.nodes() / 8},
                               {"session_bytes", link.record.memory_bytes()}}
                        .dump() +
                    "\n");
    }
}

// ---- bytes ----

core::Json cost(const std::string& by, size_t bytes, uint64_t splits, uint64_t faces) {
    return {{"by", by}, {"bytes", bytes}, {"splits", splits}, {"faces", faces}};
}

uint64_t faces_of_first(const pm::Model& model, std::span<const uint32_t> details) {
    uint64_t faces = model.header().base_faces;
    for (const uint32_t d : details)
        faces += uint64_t(model.hierarchy().faces[d].left_cut() != pm::kNone) +
                 uint64_t(model.hierarchy().faces[d].right_cut() != pm::kNone);
    return faces;
}

void count_bytes(const Scene& scene, std::span<char*> thresholds) {
    const pm::Model& model = scene.served.model();
    const std::vector<uint32_t> levels = level_order(model);
    std::vector<uint32_t> rank(levels.size());
    for (uint32_t i = 0; i != levels.size(); ++i) rank[levels[i]] = i;
    Link whole(scene.served, pm::Service::one_way);
    whole.answer(far_view(scene.served, 0), pm::Culling::off);
    const double bytes_a_split = double(whole.bytes) / double(model.details());
    pm::Selection selection(model);
    for (size_t camera = 0; camera != scene.cameras.size(); ++camera)
        for (const char* threshold : thresholds) {
            const pm::View view = scene.view(scene.cameras[camera], std::atof(threshold));
            const auto say = [&](core::Json line) {
                line["camera"] = camera, line["threshold_px"] = std::atof(threshold);
                core::print(line.dump() + "\n");
            };
            for (const auto& [name, service] :
                 {std::pair("views", pm::Service::selective), std::pair("one way", pm::Service::one_way)}) {
                Link link(scene.served, service);
                link.answer(view, pm::Culling::on);
                say(cost(name, link.bytes, link.record.count(), link.mesh().triangles.size()));
            }
            // Details stand by falling error.
            const std::vector<uint32_t> wanted = selection.select(view);
            if (wanted.empty()) continue;
            Link sorted(scene.served, pm::Service::one_way);
            sorted.answer(far_view(scene.served, pm::decode_error(model.error_code(wanted.back())) * 0.999),
                          pm::Culling::off);
            say(cost("sorted by error", sorted.bytes, sorted.record.count(), sorted.mesh().triangles.size()));
            uint32_t last = 0;
            for (const uint32_t d : wanted) last = std::max(last, rank[d]);
            const auto first = std::span(levels).first(last + 1);
            const uint64_t faces = faces_of_first(model, first);
            say(cost("by levels", size_t(bytes_a_split * double(first.size())), first.size(), faces));
            say(cost("by levels, 24 bytes a split", kPaperBytesOfSplit * first.size(), first.size(), faces));
        }
}

// ---- budgets ----

void write_mesh(const std::string& folder, const std::string& name, const mesh::Mesh& mesh, uint64_t splits,
                size_t bytes) {
    core::OutputFile out(folder + "/" + name + ".ply");
    out.write(mesh::to_ply(mesh));
    out.commit();
    core::print(
        core::Json{
            {"file", name + ".ply"}, {"splits", splits}, {"faces", mesh.triangles.size()}, {"bytes", bytes}}
            .dump() +
        "\n");
}

void spend(const Scene& scene, size_t most_bytes, const std::string& folder) {
    const pm::Model& model = scene.served.model();
    const pm::View view = scene.view(scene.cameras.front(), 0);
    const auto with = [&](const char* name, pm::Service service, const pm::View& by, pm::Culling culling) {
        Link link(scene.served, service);
        link.answer(by, culling, most_bytes);
        write_mesh(folder, name, link.mesh(), link.record.count(), link.bytes);
    };
    with("views", pm::Service::selective, view, pm::Culling::on);
    with("one-way", pm::Service::one_way, view, pm::Culling::on);
    with("sorted-by-error", pm::Service::one_way, far_view(scene.served, 0), pm::Culling::off);
    std::vector<uint32_t> first = level_order(model);
    first.resize(std::min(first.size(), most_bytes / kPaperBytesOfSplit));
    std::sort(first.begin(), first.end());
    pm::Front front(model.hierarchy());
    for (const uint32_t d : first)
        if (front.can_split(d)) front.split(d);
    write_mesh(folder, "by-levels-24", pm::mesh_of(model, front), front.split_count(),
               kPaperBytesOfSplit * first.size());
}

}  // namespace

int main(int argc, char** argv) {
    try {
        const std::string what = argc > 5 ? argv[1] : "";
        const auto rest = std::span(argv, size_t(argc)).subspan(std::min<size_t>(size_t(argc), 5));
        if (what == "session" && rest.size() == 2)
            follow_session(Scene(argv[2], argv[3], argv[4]), std::atof(rest[0]), std::atof(rest[1]));
        else if (what == "bytes")
            count_bytes(Scene(argv[2], argv[3], argv[4]), rest);
        else if (what == "budget" && rest.size() == 2)
            spend(Scene(argv[2], argv[3], argv[4]), size_t(std::atoll(rest[0])), rest[1]);
        else
            return std::fprintf(stderr, "pm_bench: session, bytes or budget, as its source says\n"), 2;
    } catch (const core::Error& error) {
        return std::fprintf(stderr, "pm_bench: %s\n", error.what()), 1;
    }
}
