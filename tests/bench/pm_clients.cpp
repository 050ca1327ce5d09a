// pm_clients: many clients of one pm-serve from one process, which decode nothing, so that what is measured
// is the server and not they.
//
//     pm_clients walk ADDRESS NAME PATH.jsonl W,H THRESHOLD CLIENTS VIEWS_PER_S
//     pm_clients idle ADDRESS NAME CLIENTS
//
// `walk`: each client looks through the path's cameras one after the other, beginning where the path does,
// and sends those that a client of pm-fetch would: where the view lacks something, or the one before has not
// been answered. A view is late where the last packet of its answer has not come when the next one's turn
// comes.  Ends with a line of JSON.
//
// `idle`: each client opens the model; a line "ready", and then they stay until standard input ends.
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <thread>
#include <vector>

#include "core/error.h"
#include "core/file.h"
#include "core/program.h"
#include "geom/camera.h"
#include "net/address.h"
#include "net/event_loop.h"
#include "net/frame_stream.h"
#include "pm/client.h"
#include "pm/messages.h"

namespace {

constexpr double kPatience_s = 60;

net::FrameStream open_model(const net::Address& address, const std::string& name) {
    net::FrameStream stream(net::connect_to(address, kPatience_s), net::to_text(address),
                            pm::kMostServerMessageBytes);
    pm::Request request;
    request.name = name;
    stream.send(to_bytes(request), kPatience_s);
    const auto body = stream.receive(kPatience_s);
    if (body.empty() || pm::parse_reply(body).kind != pm::ReplyKind::opened)
        throw core::Error(stream.name() + ": the server does not open the model");
    return stream;
}

std::vector<net::FrameStream> open_all(const net::Address& address, const std::string& name, int count) {
    std::vector<net::FrameStream> streams;
    for (int i = 0; i != count; ++i) streams.push_back(open_model(address, name));
    return streams;
}

struct Look {
    pm::View view;
    bool is_asked_for;  // it lacks something, where all before have been answered
};

std::vector<Look> look_through(const net::Address& address, const std::string& name,
                               const std::vector<pm::View>& views) {
    pm::Client client(net::FrameStream(net::connect_to(address, kPatience_s), net::to_text(address),
                                       pm::kMostServerMessageBytes));
    client.open(name);
    std::vector<Look> looks;
    for (const pm::View& view : views) {
        looks.push_back({view, client.look_at(view)});
        while (!client.is_complete()) client.wait(kPatience_s);
    }
    return looks;
}

struct Walker {
    net::FrameStream stream;
    double next_s;      // when the next view is sent
    uint32_t view = 0;  // the number of the last one
    bool is_answered = true;
    double asked_s = 0;
};

class Walk {
  public:
    Walk(std::vector<net::FrameStream> streams, std::vector<Look> looks, double views_per_s)
        : looks_(std::move(looks)), step_s_(1 / views_per_s), begun_s_(net::steady_seconds()) {
        for (net::FrameStream& stream : streams) {
            const double share = double(walkers_.size()) / double(streams.size());
            walkers_.push_back({std::move(stream), begun_s_ + share * step_s_});
        }
    }

    void run() {
        for (size_t left = walkers_.size(); left > 0;) {
            left = 0;
            for (Walker& walker : walkers_) {
                receive(walker);
                if (net::steady_seconds() >= walker.next_s) ask(walker);
                left += walker.view <= looks_.size();
            }
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
    }

    core::Json summary() {
        std::sort(latencies_ms_.begin(), latencies_ms_.end());
        const auto quantile = [&](double share) -> core::Json {
            if (latencies_ms_.empty()) return nullptr;
            return latencies_ms_[size_t(share * double(latencies_ms_.size() - 1))];
        };
        uint64_t bytes = 0;
        for (const Walker& walker : walkers_) bytes += walker.stream.bytes_received();
        return {{"clients", walkers_.size()},
                {"views", walkers_.size() * looks_.size()},
                {"asked", asked_},
                {"late", late_},
                {"last_late_s", last_late_s_},
                {"answer_ms_median", quantile(0.5)},
                {"answer_ms_99", quantile(0.99)},
                {"answer_ms_worst", quantile(1)},
                {"bytes_down", bytes}};
    }

  private:
    void receive(Walker& walker) {
        for (auto body = walker.stream.receive(0); !body.empty(); body = walker.stream.receive(0)) {
            const pm::Reply reply = pm::parse_reply(body);
            if (reply.kind == pm::ReplyKind::failed)
                throw core::Error(walker.stream.name() + ": the server says: " + reply.text);
            if (reply.view != walker.view || !reply.is_last) continue;
            walker.is_answered = true;
            latencies_ms_.push_back(1000 * (net::steady_seconds() - walker.asked_s));
        }
    }

    // The number behind the last view's is that of a walk that has ended.
    void ask(Walker& walker) {
        if (walker.view > looks_.size()) return;
        if (!walker.is_answered) {
            ++late_;
            last_late_s_ = std::max(last_late_s_, net::steady_seconds() - begun_s_);
        }
        if (walker.view++ == looks_.size()) return;
        walker.next_s += step_s_;
        const Look& look = looks_[walker.view - 1];
        if (!look.is_asked_for && walker.is_answered) return;
        pm::Request request;
        request.kind = pm::RequestKind::view;
        request.number = walker.view;
        request.view = look.view;
        walker.asked_s = net::steady_seconds();
        walker.is_answered = false;
        walker.stream.send(to_bytes(request), kPatience_s);
        ++asked_;
    }

    std::vector<Look> looks_;
    double step_s_, begun_s_, last_late_s_ = 0;
    std::vector<Walker> walkers_;
    std::vector<double> latencies_ms_;
    uint64_t asked_ = 0, late_ = 0;
};

std::vector<pm::View> read_views(const char* path, const char* size, double threshold_px) {
    int width = 0, height = 0;
    if (std::sscanf(size, "%d,%d", &width, &height) != 2) throw core::UsageError("W,H: are two numbers");
    const core::InputFile file(path);
    const std::string_view text(reinterpret_cast<const char*>(file.bytes().data()), file.bytes().size());
    std::vector<pm::View> views;
    for (const geom::Camera& camera : geom::parse_path(text, file.name()))
        views.push_back(pm::make_view(geom::make_view(camera, width, height), threshold_px));
    return views;
}

// A descriptor for each client, and those of the process.
void allow_descriptors() {
    rlimit limit{};
    getrlimit(RLIMIT_NOFILE, &limit);
    limit.rlim_cur = limit.rlim_max;
    setrlimit(RLIMIT_NOFILE, &limit);
}

}  // namespace

int main(int argc, char** argv) {
    try {
        const std::string what = argc > 1 ? argv[1] : "";
        allow_descriptors();
        if (what == "walk" && argc == 9) {
            const net::Address address = net::parse_address(argv[2]);
            std::vector<Look> looks =
                look_through(address, argv[3], read_views(argv[4], argv[5], std::atof(argv[6])));
            Walk walk(open_all(address, argv[3], std::atoi(argv[7])), std::move(looks), std::atof(argv[8]));
            walk.run();
            core::print(walk.summary().dump() + "\n");
        } else if (what == "idle" && argc == 5) {
            const auto streams = open_all(net::parse_address(argv[2]), argv[3], std::atoi(argv[4]));
            std::puts("ready");
            std::fflush(stdout);
            while (std::getchar() != EOF) {
            }
        } else {
            return std::fprintf(stderr, "pm_clients: walk or idle, as its source says\n"), 2;
        }
    } catch (const core::Error& error) {
        return std::fprintf(stderr, "pm_clients: %s\n", error.what()), 1;
    }
}
