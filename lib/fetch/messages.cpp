#include "fetch/messages.h"

#include <cmath>

#include "core/bytes.h"

namespace fetch {

namespace {

void put_text(core::ByteWriter& out, std::string_view text) {
    const auto bytes = std::as_bytes(std::span(text));
    out.bytes.insert(out.bytes.end(), bytes.begin(), bytes.end());
}

// A message from its start on; what is left must be used up by its kind.
class Reader {
  public:
    Reader(std::span<const std::byte> bytes, const char* name)
        : bytes_(bytes), reader_(bytes, name), name_(name) {
        if (bytes.size() > kMostMessageBytes) throw core::Error(std::string(name) + ": is too long");
    }
    template <class T>
    T take() {
        return reader_.take<T>();
    }
    size_t left() const { return bytes_.size() - reader_.position(); }
    std::string rest() {
        const auto text = bytes_.subspan(reader_.position());
        return {reinterpret_cast<const char*>(text.data()), text.size()};
    }
    void end() const {
        if (left() > 0) fail("has too many bytes");
    }
    [[noreturn]] void fail(const char* what) const { throw core::Error(std::string(name_) + ": " + what); }

  private:
    std::span<const std::byte> bytes_;
    core::ByteReader reader_;
    const char* name_;
};

std::vector<Want> take_wants(Reader& in) {
    if (in.left() % 8 != 0 || in.left() / 8 > kMostWants)
        in.fail("its list of blocks is of the wrong length");
    std::vector<Want> wants(in.left() / 8);
    for (Want& want : wants) {
        want.block = in.take<uint32_t>();
        want.priority = in.take<float>();
        if (!(std::isfinite(want.priority) && want.priority >= 0))
            in.fail("a priority is not a number from 0 on");
    }
    return wants;
}

Reason take_reason(Reader& in) {
    const uint32_t reason = in.take<uint32_t>();
    if (reason > uint32_t(Reason::unchecked)) in.fail("its reason is unknown");
    return Reason(reason);
}

}  // namespace

std::vector<std::byte> to_bytes(const Request& request) {
    core::ByteWriter out;
    out.put(uint32_t(request.kind));
    if (request.kind == RequestKind::open) out.put(kMessageVersion);
    if (request.kind == RequestKind::open || request.kind == RequestKind::want ||
        request.kind == RequestKind::close)
        out.put(request.stream);
    if (request.kind == RequestKind::evict) out.put(request.keep_bytes);
    for (const Want& want : request.wants) {
        out.put(want.block);
        out.put(want.priority);
    }
    put_text(out, request.url);
    return std::move(out.bytes);
}

Request parse_request(std::span<const std::byte> bytes) {
    Reader in(bytes, "request");
    Request request;
    request.kind = RequestKind(in.take<uint32_t>());
    switch (request.kind) {
        case RequestKind::open:
            if (in.take<uint32_t>() != kMessageVersion) in.fail("is of another version of qs-fetch");
            request.stream = in.take<uint32_t>();
            request.url = in.rest();
            return request;
        case RequestKind::want:
            request.stream = in.take<uint32_t>();
            request.wants = take_wants(in);
            break;
        case RequestKind::close:
            request.stream = in.take<uint32_t>();
            break;
        case RequestKind::evict:
            request.keep_bytes = in.take<uint64_t>();
            request.url = in.rest();
            return request;
        case RequestKind::status:
        case RequestKind::stop:
            break;
        default:
            in.fail("its kind is unknown");
    }
    in.end();
    return request;
}

std::vector<std::byte> to_bytes(const Reply& reply) {
    core::ByteWriter out;
    out.put(uint32_t(reply.kind));
    if (reply.kind == ReplyKind::answer)
        out.put(uint32_t(reply.is_right));
    else
        out.put(reply.stream);
    if (reply.kind == ReplyKind::opened) {
        out.put(reply.file_bytes);
        out.put(reply.block_bytes);
    }
    if (reply.kind == ReplyKind::ended || reply.kind == ReplyKind::trouble) out.put(uint32_t(reply.reason));
    put_text(out, std::string_view(reply.text).substr(0, kMostMessageBytes - out.bytes.size()));
    return std::move(out.bytes);
}

Reply parse_reply(std::span<const std::byte> bytes) {
    Reader in(bytes, "reply");
    Reply reply;
    reply.kind = ReplyKind(in.take<uint32_t>());
    const uint32_t second = in.take<uint32_t>();
    if (reply.kind == ReplyKind::answer)
        reply.is_right = second != 0;
    else
        reply.stream = second;
    switch (reply.kind) {
        case ReplyKind::opened:
            reply.file_bytes = in.take<uint64_t>();
            reply.block_bytes = in.take<uint32_t>();
            break;
        case ReplyKind::arrived:
            break;
        case ReplyKind::ended:
        case ReplyKind::trouble:
            reply.reason = take_reason(in);
            reply.text = in.rest();
            return reply;
        case ReplyKind::answer:
            reply.text = in.rest();
            return reply;
        default:
            in.fail("its kind is unknown");
    }
    in.end();
    return reply;
}

}  // namespace fetch
