#include "pm/client.h"

#include <algorithm>

#include "core/bytes.h"
#include "pm/answer.h"
#include "pm/served_model.h"

namespace pm {

namespace {

constexpr char kStateMagic[8] = {'q', 's', 'p', 'm', 's', 't', 'a', '\n'};
constexpr uint16_t kStateVersion = 1;

// A number costs the server more than so few bits; so what is taken is bounded by what was sent.
constexpr uint64_t kMostPerByte = 8;

Replica make_replica(std::span<const std::byte> header_bytes, std::span<const std::byte> base_packet,
                     Service service, const std::string& name) {
    const Header header = parse_header(header_bytes, name);
    const uint64_t most = kMostPerByte * (base_packet.size() + 16);
    if (header.base_vertices > most || header.base_faces > most || header.depth > 0xfffe)
        throw core::Error(name + ": its base mesh is not as large as its header says");
    BaseMesh base = decode_base(header, base_packet, tells_bounds(service));
    return Replica(header, std::move(base.vertices), std::move(base.faces), base.nodes);
}

struct StateModels {
    SignedModel<32> node;
    BitModel has_cone;
    SplitModels split;
};

// What a state says behind its base mesh.  Nodes are numbered as they came.
template <class Coder>
void code_splits(Coder& coder, uint32_t count, const Replica* from, Replica& to) {
    auto models = std::make_unique<StateModels>();
    Ring ring;
    SplitPlace place;
    uint32_t before = 0;
    for (uint32_t s = 0; s != count; ++s) {
        if constexpr (requires { coder.is_beyond_end(); })
            if (coder.is_beyond_end()) throw core::Error("it is cut off");
        const int64_t given = from ? int64_t(from->node_of_split(s)) - before : 0;
        const int64_t node = before + code_signed(coder, models->node, given);
        if (node < 0 || node >= int64_t(to.nodes().size()) || to.node(uint32_t(node)).is_leaf ||
            to.node(uint32_t(node)).split != kNone)
            throw core::Error("a node cannot be split");
        to.find_ring(to.node(uint32_t(node)).vertex, ring);
        const SplitData data = from ? from->split_data(s) : SplitData();
        to.find_place(uint32_t(node), ring, place);
        to.apply(uint32_t(node), code_split(coder, models->split, to.header(), to.has_bounds(), place, data),
                 ring);
        before = uint32_t(node);
    }
    for (uint32_t n = 0; to.has_bounds() && n != to.nodes().size(); ++n)
        if (!to.node(n).is_leaf && coder.bit(models->has_cone, from && from->node(n).has_cone))
            to.learn_cone(n, code_cone(coder, from ? from->node(n).cone : ConeCodes{}));
}

}  // namespace

// ---- states ----

ClientState::ClientState(const std::array<std::byte, kHeaderSize>& header, std::vector<std::byte> base_packet,
                         Service service)
    : header_bytes_(header),
      base_packet_(std::move(base_packet)),
      service_(service),
      replica_(std::make_unique<Replica>(make_replica(header_bytes_, base_packet_, service, "model"))) {}

std::vector<std::byte> ClientState::to_bytes() const {
    core::ByteWriter out;
    const auto put = [&](std::span<const std::byte> bytes) {
        out.bytes.insert(out.bytes.end(), bytes.begin(), bytes.end());
    };
    out.bytes.reserve(64 + kHeaderSize + base_packet_.size());
    put(std::as_bytes(std::span(kStateMagic)));
    out.put(kStateVersion);
    out.put(uint8_t(service_));
    put(header_bytes_);
    out.put(uint32_t(base_packet_.size()));
    put(base_packet_);
    out.put(replica_->split_count());
    Replica again = make_replica(header_bytes_, base_packet_, service_, "model");
    RangeEncoder encoder;
    code_splits(encoder, replica_->split_count(), replica_.get(), again);
    put(encoder.finish());
    return std::move(out.bytes);
}

ClientState ClientState::from_bytes(std::span<const std::byte> bytes, const std::string& name) {
    core::ByteReader in(bytes, name);
    const auto take = [&](size_t count) {
        const auto left = bytes.subspan(in.position());
        if (count > left.size())
            throw core::Error(name + ": cut off at byte " + std::to_string(bytes.size()));
        for (size_t i = 0; i != count; ++i) in.take<std::byte>();
        return left.first(count);
    };
    const auto magic = take(sizeof kStateMagic);
    if (!std::equal(magic.begin(), magic.end(), std::as_bytes(std::span(kStateMagic)).begin()))
        throw core::Error(name + ": is no state of pm-fetch");
    if (in.take<uint16_t>() != kStateVersion) throw core::Error(name + ": is of another version of pm-fetch");
    const uint8_t service = in.take<uint8_t>();
    if (service > uint8_t(Service::lists)) throw core::Error(name + ": is of a service that is unknown");
    std::array<std::byte, kHeaderSize> header{};
    std::copy_n(take(kHeaderSize).begin(), kHeaderSize, header.begin());
    const uint32_t base_size = in.take<uint32_t>();
    const auto base = take(base_size);
    const uint32_t splits = in.take<uint32_t>();
    try {
        ClientState state(header, {base.begin(), base.end()}, Service(service));
        if (splits > state.header().details) throw core::Error("it has more splits than the model");
        RangeDecoder decoder(bytes.subspan(in.position()));
        code_splits(decoder, splits, nullptr, state.replica());
        if (decoder.is_beyond_end()) throw core::Error("it is cut off");
        return state;
    } catch (const core::Error& error) {
        throw core::Error(name + ": " + error.what());
    }
}

// ---- the connection ----

Client::Client(net::FrameStream stream, double timeout_s)
    : stream_(std::move(stream)), timeout_s_(timeout_s) {}

Client::~Client() = default;

Reply Client::expect(ReplyKind kind) {
    const std::span<const std::byte> body = stream_.receive(timeout_s_);
    if (body.empty()) throw core::Error(stream_.name() + ": the server does not answer");
    Reply reply = parse_reply(body);
    if (reply.kind == ReplyKind::failed)
        throw core::Error(stream_.name() + ": the server says: " + reply.text);
    if (reply.kind != kind) throw core::Error(stream_.name() + ": the server answers something else");
    return reply;
}

std::string Client::ask(RequestKind kind) {
    Request request;
    request.kind = kind;
    stream_.send(to_bytes(request), timeout_s_);
    return expect(ReplyKind::answer).text;
}

void Client::begin(ClientState state) {
    state_ = std::make_unique<ClientState>(std::move(state));
    models_ = std::make_unique<SplitModels>();
    front_ = std::make_unique<Front>(state_->replica().hierarchy());
}

void Client::open(const std::string& name, Service service) {
    if (name.size() > kMostNameBytes) throw core::UsageError("the name of the model is too long");
    Request request;
    request.name = name;
    request.service = service;
    stream_.send(to_bytes(request), timeout_s_);
    const Reply reply = expect(ReplyKind::opened);
    begin(ClientState(reply.header, reply.bytes, service));
}

void Client::resume(const std::string& name, ClientState state) {
    Request request;
    request.kind = RequestKind::resume;
    request.name = name;
    request.service = state.service();
    request.hash = state.hash();
    state.replica().forget_cuts();
    request.bytes = encode_record(state.replica());
    stream_.send(to_bytes(request), timeout_s_);
    if (expect(ReplyKind::resumed).splits != state.replica().split_count())
        throw core::Error(stream_.name() + ": the server counts other splits than were received");
    begin(std::move(state));
}

// ---- what is asked for ----

void Client::send(Request request) {
    request.number = ++number_;
    sent_[number_] = last_;
    ++counts_.requests_sent;
    stream_.send(to_bytes(request), timeout_s_);
}

std::unique_ptr<Sweep<Replica>> Client::make_sweep(const Sought& sought) const {
    return std::make_unique<Sweep<Replica>>(state_->replica(), sought.view, state_->header().placement,
                                            sought.culling);
}

bool Client::look_at(const View& view, Culling culling) {
    last_ = {view, culling};
    switch (state_->service()) {
        case Service::selective: {
            auto sweep = make_sweep(last_);
            if (sweep->current() != kNone) return ask_for_view();
            // Nothing is asked; answers to earlier views may still come.
            if (sent_.empty()) sweep_ = std::move(sweep), answer_number_ = 0;
            return false;
        }
        case Service::one_way:
            return !(sent_.empty() && answered_ == last_) && ask_for_view();
        case Service::lists:
            return !sent_.empty() || ask_for_list();
    }
    return false;
}

bool Client::ask_for_view() {
    Request request;
    request.kind = RequestKind::view;
    request.view = last_.view;
    request.culling = last_.culling;
    send(request);
    return true;
}

bool Client::ask_for_list() {
    const auto sweep = make_sweep(last_);
    if (sweep->current() == kNone) return false;
    NodeList list = make_list(state_->replica(), *models_, *sweep, kMostDecisions);
    listed_ = std::move(list.nodes);
    Request request;
    request.kind = RequestKind::list;
    request.bytes = std::move(list.bytes);
    send(request);
    return true;
}

// ---- what comes ----

void Client::begin_answer(const Sought& sought) {
    if (state_->service() == Service::selective) sweep_ = make_sweep(sought);
    if (state_->service() == Service::one_way)
        passes_ = std::make_unique<PassCursor<Replica>>(state_->replica());
}

void Client::take_decisions(const Reply& packet) {
    Replica& replica = state_->replica();
    switch (state_->service()) {
        case Service::selective:
            return take_packet(replica, *models_, *sweep_, packet.decisions, packet.check, packet.bytes);
        case Service::one_way:
            return take_one_way(replica, *models_, *passes_, packet.decisions, packet.check, packet.bytes);
        case Service::lists:
            if (packet.decisions > listed_.size() || packet.is_last != (packet.decisions == listed_.size()))
                throw core::Error("a packet does not answer the list");
            take_list_packet(replica, *models_, std::span(listed_).first(packet.decisions), packet.check,
                             packet.bytes);
            listed_.erase(listed_.begin(), listed_.begin() + packet.decisions);
    }
}

void Client::take(const Reply& packet) {
    const auto sought = sent_.find(packet.view);
    if (sought == sent_.end()) throw core::Error("a packet answers a view that was not sent");
    // Views before it will not be answered any more.
    sent_.erase(sent_.begin(), sought);
    if (packet.is_first) {
        begin_answer(sought->second);
        answer_number_ = packet.view;
    }
    if (answer_number_ != packet.view) throw core::Error("a packet's view has not begun");
    const uint32_t before = state_->replica().split_count();
    take_decisions(packet);
    ++counts_.packets;
    counts_.splits += state_->replica().split_count() - before;
    if (!packet.is_last) return;
    answered_ = sought->second;
    sent_.erase(packet.view);
    // Of the children of what has come, and of what the view is now.
    if (state_->service() == Service::lists) ask_for_list();
}

bool Client::wait(double timeout_s) {
    bool has_come = false;
    for (;;) {
        const std::span<const std::byte> body = stream_.receive(has_come ? 0 : timeout_s);
        if (body.empty()) return has_come;
        has_come = true;
        try {
            const Reply reply = parse_reply(body);
            if (reply.kind == ReplyKind::failed) throw core::Error("the server says: " + reply.text);
            if (reply.kind != ReplyKind::packet) throw core::Error("the server answers something else");
            take(reply);
        } catch (const core::Error& error) {
            throw core::Error(stream_.name() + ": " + error.what());
        }
    }
}

const Front& Client::refine() {
    Replica& replica = state_->replica();
    front_->grow(replica.hierarchy());
    if (!replica.has_bounds()) {
        for (uint32_t s = front_->split_count(); s != replica.split_count(); ++s) front_->split(s);
        return *front_;
    }
    const auto sweep = make_sweep(last_);
    const auto is_wanted = [&](uint32_t split) { return sweep->is_wanted(replica.node_of_split(split)); };
    // What is not wanted is depended on by nothing that is, and what is wanted depends on nothing that is
    // not.
    for (uint32_t s = replica.split_count(); s-- > 0;)
        if (!is_wanted(s) && front_->is_split(s)) front_->collapse(s);
    for (uint32_t s = 0; s != replica.split_count(); ++s)
        if (is_wanted(s) && !front_->is_split(s)) front_->split(s);
    return *front_;
}

}  // namespace pm
