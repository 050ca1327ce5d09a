#include "pm/server.h"

#include <list>
#include <map>

#include "pm/answer.h"
#include "pm/lists.h"
#include "pm/one_way.h"

namespace pm {

namespace {

class Session;

// The replicas of those clients that were answered last.
class ReplicaCache {
  public:
    explicit ReplicaCache(size_t most_bytes) : most_bytes_(most_bytes) {}

    // Of this session, made anew where it is missing.  Valid until the next call for another session.
    ServedReplica& get(const Session* of, const ServedModel& served, const SentRecord& record) {
        const auto found = places_.find(of);
        if (found != places_.end()) {
            entries_.splice(entries_.begin(), entries_, found->second);
            return *entries_.front().replica;
        }
        ++built_;
        entries_.push_front({of, std::make_unique<ServedReplica>(served, record)});
        places_[of] = entries_.begin();
        return *entries_.front().replica;
    }
    void forget(const Session* of) {
        const auto found = places_.find(of);
        if (found == places_.end()) return;
        entries_.erase(found->second);
        places_.erase(found);
    }
    // The one that is in use stays.
    void shrink() {
        size_t bytes = 0;
        auto entry = entries_.begin();
        for (size_t i = 0; entry != entries_.end(); ++i) {
            bytes += entry->replica->memory_bytes();
            if (i == 0 || bytes <= most_bytes_) {
                ++entry;
                continue;
            }
            bytes -= entry->replica->memory_bytes();
            places_.erase(entry->of);
            entry = entries_.erase(entry);
        }
    }
    bool holds(const Session* of) const { return places_.contains(of); }
    size_t size() const { return entries_.size(); }
    size_t bytes() const {
        size_t bytes = 0;
        for (const Entry& entry : entries_) bytes += entry.replica->memory_bytes();
        return bytes;
    }
    uint64_t built() const { return built_; }

  private:
    struct Entry {
        const Session* of;
        std::unique_ptr<ServedReplica> replica;
    };
    size_t most_bytes_;
    std::list<Entry> entries_;  // the last one that was used first
    std::map<const Session*, std::list<Entry>::iterator> places_;
    uint64_t built_ = 0;
};

struct Counts {
    uint64_t sessions = 0, resumed = 0, views = 0, views_replaced = 0, packets = 0;
    AnswerCounts sent;
};

// What sessions share.
struct Shared {
    std::map<std::string, std::unique_ptr<ServedModel>> models;
    ServerOptions options;
    ReplicaCache replicas;
    Counts counts;
    std::function<core::Json()> status;

    explicit Shared(const ServerOptions& given) : options(given), replicas(given.most_replica_bytes) {}
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
    ~Session() override {
        answer_.reset();
        shared_.replicas.forget(this);
    }

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
        if (!has_view_ && !answer_) connection.finish();
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
    void start_answer();
    std::unique_ptr<PacketSource> make_answer(ServedReplica& replica, bool is_new);

    net::Connection& connection_;
    Shared& shared_;
    const ServedModel* served_ = nullptr;
    Service service_ = Service::selective;
    std::unique_ptr<SentRecord> record_;    // from the first view on
    std::unique_ptr<PacketSource> answer_;  // to what is being answered; uses this session's replica
    AnswerCounts counted_;                  // of answer_, already in the shared counts
    bool has_view_ = false, is_input_ended_ = false;
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
    if (has_view_ || answer_) {
        // A list speaks of what the client has when it has taken the answer to the one before.
        if (service_ == Service::lists) throw core::Error("it sends a list before the last one was answered");
        ++shared_.counts.views_replaced;
    }
    number_ = request.number;
    view_ = request;
    has_view_ = true;
    connection_.ask_turn();
}

void Session::start_answer() {
    const bool is_new = std::exchange(has_view_, false);
    answer_.reset();
    if (!record_) record_ = std::make_unique<SentRecord>(service_);
    answer_ = make_answer(shared_.replicas.get(this, *served_, *record_), is_new);
    counted_ = AnswerCounts();
    shared_.counts.views += is_new;
}

std::unique_ptr<PacketSource> Session::make_answer(ServedReplica& replica, bool is_new) {
    switch (service_) {
        case Service::selective:
            return std::make_unique<Answer>(*served_, *record_, replica, view_.view, view_.culling);
        case Service::one_way:
            return std::make_unique<OneWayAnswer>(*served_, *record_, replica, view_.view, view_.culling);
        case Service::lists:
            if (is_new) listed_ = read_list(replica, record_->models, view_.bytes);
            return std::make_unique<ListAnswer>(*served_, *record_, replica, listed_);
    }
    throw core::Error("its service is unknown");
}

// One packet.
void Session::turn() {
    // With a replica that was given up for others goes the answer that used it, to be begun again.
    const bool begins = has_view_ || (answer_ && !shared_.replicas.holds(this));
    if (begins) start_answer();
    if (!answer_) return;
    shared_.replicas.get(this, *served_, *record_);  // used now
    const Packet packet = answer_->next(shared_.options.packet_decisions);
    if (service_ == Service::lists) listed_.erase(listed_.begin(), listed_.begin() + packet.decisions);
    Reply reply;
    reply.kind = ReplyKind::packet;
    reply.view = view_.number;
    reply.decisions = uint16_t(packet.decisions);
    reply.is_first = begins;
    reply.is_last = packet.is_last;
    reply.check = packet.check;
    reply.bytes = packet.bytes;
    ++shared_.counts.packets;
    const AnswerCounts& now = answer_->counts();
    AnswerCounts& sum = shared_.counts.sent;
    sum.splits += now.splits - counted_.splits;
    sum.cones += now.cones - counted_.cones;
    sum.cuts += now.cuts - counted_.cuts;
    counted_ = now;
    if (packet.is_last) answer_.reset();
    shared_.replicas.shrink();
    connection_.send(to_bytes(reply));
    if (answer_ || has_view_)
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
                   {"replicas", shared.replicas.size()},
                   {"replica_bytes", shared.replicas.bytes()},
                   {"replicas_built", shared.replicas.built()},
                   {"views", shared.counts.views},
                   {"views_replaced", shared.counts.views_replaced},
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
