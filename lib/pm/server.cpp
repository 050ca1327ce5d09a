#include "pm/server.h"

#include <algorithm>
#include <map>
#include <utility>

#include "pm/answer.h"
#include "pm/lists.h"
#include "pm/one_way.h"

namespace pm {

namespace {

class Session;

// Of an answer that begins again: for so many splits that the client has, one decision at least.  Looking at
// one takes some 60 ns, making one some 3 us.
constexpr uint32_t kSplitsByDecision = 8;

// The answers that are being made.  What is cheap to begin again is given up first: that of the client with
// the fewest splits.
class Answers {
  public:
    // Null where the session has none, or it was given up.
    PacketSource* find(const Session* of) {
        const auto found = of_.find(of);
        return found == of_.end() ? nullptr : found->second.source.get();
    }
    PacketSource& begin(const Session* of, uint32_t splits, std::unique_ptr<PacketSource> source) {
        ++begun_;
        Answer& answer = of_[of];
        answer = {splits, std::move(source)};
        return *answer.source;
    }
    void forget(const Session* of) { of_.erase(of); }
    void shrink() {
        while (of_.size() > kMostUnfinished)
            of_.erase(std::min_element(of_.begin(), of_.end(), [](const auto& a, const auto& b) {
                return a.second.splits < b.second.splits;
            }));
    }
    uint64_t begun() const { return begun_; }

  private:
    struct Answer {
        uint32_t splits = 0;  // of the client, when it was begun
        std::unique_ptr<PacketSource> source;
    };
    std::map<const Session*, Answer> of_;
    uint64_t begun_ = 0;
};

struct Counts {
    uint64_t sessions = 0, resumed = 0, views = 0, views_replaced = 0, packets = 0;
    AnswerCounts sent;
};

// What sessions share.
struct Shared {
    std::map<std::string, std::unique_ptr<ServedModel>> models;
    ServerOptions options;
    Answers answers;
    Counts counts;
    std::function<core::Json()> status;

    explicit Shared(const ServerOptions& given) : options(given) {}
    const ServedModel& find(const std::string& name) const {
        // A server of one model needs no name.
        const auto found = name.empty() && models.size() == 1 ? models.begin() : models.find(name);
        if (found == models.end()) throw core::Error("'" + name + "' is not in the catalogue");
        return *found->second;
    }
};

core::Json catalogue_json(const Shared& shared) {
    core::Json list = core::Json::array();
    for (const auto& [name, served] : shared.models) {
        const Model& model = served->model();
        list.push_back({{"name", name},
                        {"hash", core::text("%016llx", static_cast<unsigned long long>(model.hash()))},
                        {"base_vertices", model.header().base_vertices},
                        {"base_faces", model.header().base_faces},
                        {"splits", model.details()},
                        {"faces", model.header().faces},
                        {"bits", model.header().bits}});
    }
    return list;
}

class Session : public net::Session {
  public:
    Session(net::Connection& connection, Shared& shared) : connection_(connection), shared_(shared) {}
    ~Session() override { shared_.answers.forget(this); }

    void received(std::span<const std::byte> body) override {
        const Request request = parse_request(body);
        switch (request.kind) {
            case RequestKind::open:
                return open(request);
            case RequestKind::resume:
                return resume(request);
            case RequestKind::view:
            case RequestKind::list:
                return answer(request);
            case RequestKind::status:
                return say(shared_.status().dump());
            case RequestKind::catalogue:
                return say(catalogue_json(shared_).dump());
        }
    }
    void turn() override;
    void input_ended(net::Connection& connection) override {
        is_input_ended_ = true;
        if (!has_view_ && !is_answering_) connection.finish();
    }
    std::vector<std::byte> farewell(const std::string& why) override {
        Reply reply;
        reply.text = why;
        return to_bytes(reply);
    }
    size_t memory_bytes() const { return sizeof *this + (record_ ? record_->memory_bytes() : 0); }

  private:
    void say(const std::string& text) {
        Reply reply;
        reply.kind = ReplyKind::answer;
        reply.text = text;
        connection_.send(to_bytes(reply));
    }
    void begin(const Request& request) {
        if (served_) throw core::Error("it has a model already; connect again for another one");
        served_ = &shared_.find(request.name);
        service_ = request.service;
    }
    void open(const Request& request);
    void resume(const Request& request);
    void answer(const Request& request);
    PacketSource& begin_answer(bool is_new);
    std::unique_ptr<PacketSource> make_answer(bool is_new);
    void send_packet(PacketSource& source, bool is_first);

    net::Connection& connection_;
    Shared& shared_;
    const ServedModel* served_ = nullptr;
    Service service_ = Service::selective;
    std::unique_ptr<SentRecord> record_;  // from the first view on
    bool has_view_ = false;               // that is not being answered yet
    bool is_answering_ = false;           // by what of shared_.answers is this session's, unless given up
    bool is_input_ended_ = false;
    uint32_t number_ = 0;           // of the last view or list
    Request view_;                  // or list: that is to be answered next, or being answered
    std::vector<uint32_t> listed_;  // details that a list asks for and that were not answered
};

void Session::open(const Request& request) {
    begin(request);
    ++shared_.counts.sessions;
    Reply reply;
    reply.kind = ReplyKind::opened;
    reply.header = encode_header(served_->model().header());
    const std::span<const std::byte> base = served_->base_packet(service_);
    reply.bytes.assign(base.begin(), base.end());
    connection_.send(to_bytes(reply));
}

void Session::resume(const Request& request) {
    begin(request);
    if (request.hash != served_->model().hash())
        throw core::Error("'" + request.name +
                          "' is not the model that the client has (its hash differs); it cannot be resumed");
    record_ = std::make_unique<SentRecord>(decode_record(*served_, request.bytes, service_));
    ++shared_.counts.resumed;
    Reply reply;
    reply.kind = ReplyKind::resumed;
    reply.splits = record_->count();
    connection_.send(to_bytes(reply));
}

void Session::answer(const Request& request) {
    if (!served_) throw core::Error("it sends a view before it has a model");
    if (number_ != 0 && request.number <= number_) throw core::Error("its views are not numbered in turn");
    if (request.number == 0) throw core::Error("its views are not numbered from 1 on");
    if ((request.kind == RequestKind::list) != (service_ == Service::lists))
        throw core::Error("its service has lists in the place of views, or views in that of lists");
    if (has_view_ || is_answering_) {
        // A list speaks of what the client has when it has taken the answer to the one before.
        if (service_ == Service::lists) throw core::Error("it sends a list before the last one was answered");
        ++shared_.counts.views_replaced;
    }
    number_ = request.number;
    view_ = request;
    has_view_ = true;
    connection_.ask_turn();
}

PacketSource& Session::begin_answer(bool is_new) {
    if (!record_) record_ = std::make_unique<SentRecord>(service_);
    shared_.counts.views += is_new;
    is_answering_ = true;
    return shared_.answers.begin(this, record_->count(), make_answer(is_new));
}

std::unique_ptr<PacketSource> Session::make_answer(bool is_new) {
    switch (service_) {
        case Service::selective:
            return std::make_unique<Answer>(*served_, *record_, view_.view, view_.culling);
        case Service::one_way:
            return std::make_unique<OneWayAnswer>(*served_, *record_, view_.view, view_.culling);
        case Service::lists:
            if (is_new) listed_ = read_list(*served_, *record_, view_.bytes);
            return std::make_unique<ListAnswer>(*served_, *record_, listed_);
    }
    throw core::Error("its service is unknown");
}

void Session::send_packet(PacketSource& source, bool is_first) {
    const AnswerCounts before = source.counts();
    const Packet packet = source.next(shared_.options.packet_decisions);
    if (service_ == Service::lists) listed_.erase(listed_.begin(), listed_.begin() + packet.decisions);
    Reply reply;
    reply.kind = ReplyKind::packet;
    reply.view = view_.number;
    reply.decisions = uint16_t(packet.decisions);
    reply.is_first = is_first;
    reply.is_last = packet.is_last;
    reply.check = packet.check;
    reply.bytes = packet.bytes;
    ++shared_.counts.packets;
    AnswerCounts& sum = shared_.counts.sent;
    sum.splits += source.counts().splits - before.splits;
    sum.cones += source.counts().cones - before.cones;
    sum.cuts += source.counts().cuts - before.cuts;
    is_answering_ = !packet.is_last;
    connection_.send(to_bytes(reply));
}

// One packet; of an answer that begins again as many as are worth the beginning.
void Session::turn() {
    const bool is_new = std::exchange(has_view_, false);
    if (!is_new && !is_answering_) return;
    PacketSource* source = is_new ? nullptr : shared_.answers.find(this);
    const bool begins = source == nullptr;
    if (begins) source = &begin_answer(is_new);
    const uint32_t worth = begins && !is_new ? record_->count() / kSplitsByDecision : 0;
    const uint32_t from = record_->count();
    send_packet(*source, begins);
    while (is_answering_ && record_->count() - from < worth &&
           connection_.queued_bytes() < shared_.options.limits.connection.most_queued_bytes)
        send_packet(*source, false);
    if (!is_answering_) shared_.answers.forget(this);
    shared_.answers.shrink();
    if (is_answering_ || has_view_)
        connection_.ask_turn();
    else if (is_input_ended_)
        connection_.finish();
}

}  // namespace

struct Server::State {
    Shared shared;
    net::Server server;

    State(net::EventLoop& loop, const std::vector<CatalogueEntry>& catalogue, const ServerOptions& options)
        : shared(options),
          server(
              loop, limits_of(catalogue),
              [this](net::Connection& connection) { return std::make_unique<Session>(connection, shared); },
              busy()) {}

    // Loads the models, since what clients may send at most follows from them.
    net::ServerLimits limits_of(const std::vector<CatalogueEntry>& catalogue) {
        uint32_t most_details = 0;
        for (const CatalogueEntry& entry : catalogue) {
            auto served = std::make_unique<ServedModel>(Model(entry.path));
            most_details = std::max(most_details, served->model().details());
            if (!shared.models.emplace(entry.name, std::move(served)).second)
                throw core::Error(entry.path + ": another model has the name '" + entry.name + "' already");
        }
        net::ServerLimits limits = shared.options.limits;
        // The record of a client is less than two bits for each of the details, and those for its cones.
        limits.connection.most_frame_bytes = 4096 + most_details / 2;
        return limits;
    }
    static std::vector<std::byte> busy() {
        Reply reply;
        reply.text = "the server has as many clients as it takes; try again later";
        return to_bytes(reply);
    }
    core::Json status() const;
};

core::Json Server::State::status() const {
    size_t session_bytes = 0;
    server.for_each([&](const net::Session& session) {
        session_bytes += static_cast<const Session&>(session).memory_bytes();
    });
    core::Json status = net::to_json(server.counts());
    status.update({{"models", shared.models.size()},
                   {"sessions_opened", shared.counts.sessions},
                   {"sessions_resumed", shared.counts.resumed},
                   {"session_bytes", session_bytes},
                   {"views", shared.counts.views},
                   {"views_replaced", shared.counts.views_replaced},
                   {"answers_begun", shared.answers.begun()},
                   {"packets", shared.counts.packets},
                   {"splits_sent", shared.counts.sent.splits},
                   {"cones_sent", shared.counts.sent.cones},
                   {"blocked_told", shared.counts.sent.cuts}});
    return status;
}

Server::Server(net::EventLoop& loop, const std::vector<CatalogueEntry>& catalogue,
               const ServerOptions& options)
    : state_(std::make_unique<State>(loop, catalogue, options)) {
    state_->shared.status = [this] { return state_->status(); };
}

Server::~Server() = default;

void Server::listen(net::Listener listener) {
    state_->server.listen(std::move(listener));
}

void Server::serve_one(core::Descriptor in, core::Descriptor out) {
    state_->server.serve_one(std::move(in), std::move(out));
}

core::Json Server::status() const {
    return state_->status();
}

}  // namespace pm
