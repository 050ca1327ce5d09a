#include "pm/messages.h"

#include <algorithm>

#include "core/bytes.h"

namespace pm {

namespace {

constexpr uint32_t kIsLast = 0x8000, kIsFirst = 0x4000;  // beside the decisions

void put_bytes(core::ByteWriter& out, std::span<const std::byte> bytes) {
    out.bytes.insert(out.bytes.end(), bytes.begin(), bytes.end());
}

void put_text(core::ByteWriter& out, const std::string& text) {
    put_bytes(out, std::as_bytes(std::span(text)));
}

// A message from its start on; what is left must be used up by its kind.
class Reader {
  public:
    Reader(std::span<const std::byte> bytes, const char* name)
        : bytes_(bytes), reader_(bytes, name), name_(name) {}
    template <class T>
    T take() {
        return reader_.take<T>();
    }
    std::span<const std::byte> take_bytes(size_t count) {
        const auto left = bytes_.subspan(reader_.position());
        if (count > left.size()) fail("is cut off");
        for (size_t i = 0; i != count; ++i) reader_.take<std::byte>();
        return left.first(count);
    }
    std::span<const std::byte> rest() { return take_bytes(bytes_.size() - reader_.position()); }
    void end() const {
        if (reader_.position() != bytes_.size()) fail("has too many bytes");
    }
    [[noreturn]] void fail(const char* what) const { throw core::Error(std::string(name_) + ": " + what); }

  private:
    std::span<const std::byte> bytes_;
    core::ByteReader reader_;
    const char* name_;
};

std::string text_of(std::span<const std::byte> bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

// eye, right, down, forward, low, high, tolerance
template <class Number>
void for_each_number(Number&& number, View& view) {
    for (glm::dvec3* v : {&view.eye, &view.right, &view.down, &view.forward})
        for (int i = 0; i != 3; ++i) number((*v)[i]);
    for (glm::dvec2* v : {&view.low, &view.high})
        for (int i = 0; i != 2; ++i) number((*v)[i]);
    number(view.tolerance);
}

void take_greeting(Reader& in, Request& request) {
    if (in.take<uint16_t>() != kProtocolVersion)
        in.fail("is of another version of the protocol; this server speaks version 1");
    const uint8_t service = in.take<uint8_t>();
    if (service > uint8_t(Service::lists)) in.fail("asks for a service that is unknown");
    request.service = Service(service);
    if (request.kind == RequestKind::resume) request.hash = in.take<uint64_t>();
    const uint16_t size = in.take<uint16_t>();
    if (size > kMostNameBytes) in.fail("has a name that is too long");
    request.name = text_of(in.take_bytes(size));
}

}  // namespace

std::vector<std::byte> to_bytes(const Request& request) {
    core::ByteWriter out;
    out.put(uint8_t(request.kind));
    if (request.kind == RequestKind::open || request.kind == RequestKind::resume) {
        out.put(kProtocolVersion);
        out.put(uint8_t(request.service));
        if (request.kind == RequestKind::resume) out.put(request.hash);
        out.put(uint16_t(request.name.size()));
        put_text(out, request.name);
    }
    if (request.kind == RequestKind::view || request.kind == RequestKind::list) out.put(request.number);
    if (request.kind == RequestKind::resume || request.kind == RequestKind::list)
        put_bytes(out, request.bytes);
    if (request.kind == RequestKind::view) {
        out.put(uint8_t(request.culling));
        View view = request.view;
        for_each_number([&](double value) { out.put(value); }, view);
    }
    return std::move(out.bytes);
}

Request parse_request(std::span<const std::byte> bytes) {
    Reader in(bytes, "request");
    Request request;
    request.kind = RequestKind(in.take<uint8_t>());
    const auto take_rest = [&] {
        const auto rest = in.rest();
        request.bytes.assign(rest.begin(), rest.end());
    };
    switch (request.kind) {
        case RequestKind::open:
            take_greeting(in, request);
            break;
        case RequestKind::resume:
            take_greeting(in, request);
            take_rest();
            break;
        case RequestKind::list:
            request.number = in.take<uint32_t>();
            take_rest();
            break;
        case RequestKind::view: {
            request.number = in.take<uint32_t>();
            const uint8_t culling = in.take<uint8_t>();
            if (culling > uint8_t(Culling::off)) in.fail("has a way of culling that is unknown");
            request.culling = Culling(culling);
            for_each_number([&](double& value) { value = in.take<double>(); }, request.view);
            check(request.view);
            break;
        }
        case RequestKind::status:
        case RequestKind::catalogue:
            break;
        default:
            in.fail("its kind is unknown");
    }
    in.end();
    return request;
}

std::vector<std::byte> to_bytes(const Reply& reply) {
    core::ByteWriter out;
    out.put(uint8_t(reply.kind));
    switch (reply.kind) {
        case ReplyKind::opened:
            out.put(kProtocolVersion);
            put_bytes(out, reply.header);
            put_bytes(out, reply.bytes);
            break;
        case ReplyKind::resumed:
            out.put(kProtocolVersion);
            out.put(reply.splits);
            break;
        case ReplyKind::packet:
            out.put(reply.view);
            out.put(
                uint16_t(reply.decisions | (reply.is_last ? kIsLast : 0) | (reply.is_first ? kIsFirst : 0)));
            out.put(reply.check);
            put_bytes(out, reply.bytes);
            break;
        case ReplyKind::failed:
        case ReplyKind::answer:
            put_text(out, reply.text);
            break;
    }
    return std::move(out.bytes);
}

Reply parse_reply(std::span<const std::byte> bytes) {
    Reader in(bytes, "reply");
    Reply reply;
    reply.kind = ReplyKind(in.take<uint8_t>());
    const auto take_version = [&] {
        if (in.take<uint16_t>() != kProtocolVersion)
            in.fail("is of another version of the protocol; this program speaks version 1");
    };
    const auto take_rest = [&] {
        const auto rest = in.rest();
        reply.bytes.assign(rest.begin(), rest.end());
    };
    switch (reply.kind) {
        case ReplyKind::opened: {
            take_version();
            const auto header = in.take_bytes(kHeaderSize);
            std::copy(header.begin(), header.end(), reply.header.begin());
            take_rest();
            break;
        }
        case ReplyKind::resumed:
            take_version();
            reply.splits = in.take<uint32_t>();
            break;
        case ReplyKind::packet: {
            reply.view = in.take<uint32_t>();
            const uint16_t decisions = in.take<uint16_t>();
            reply.is_last = (decisions & kIsLast) != 0;
            reply.is_first = (decisions & kIsFirst) != 0;
            reply.decisions = uint16_t(decisions & ~(kIsLast | kIsFirst));
            if (reply.decisions > kMostDecisions) in.fail("has too many decisions");
            reply.check = in.take<uint16_t>();
            take_rest();
            break;
        }
        case ReplyKind::failed:
        case ReplyKind::answer:
            reply.text = text_of(in.rest());
            break;
        default:
            in.fail("its kind is unknown");
    }
    in.end();
    return reply;
}

}  // namespace pm
