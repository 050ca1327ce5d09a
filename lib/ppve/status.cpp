#include "ppve/status.h"

#include <algorithm>

#include "core/error.h"
#include "net/address.h"
#include "net/frame_stream.h"
#include "ppve/messages.h"

namespace ppve {

void SessionCounts::add(const AnswerReport& report) {
    if (report.is_refused) {
        ++requests_refused;
        return;
    }
    ++updates;
    updates_anew += report.starts_anew;
    elimination.samples += report.elimination.samples, elimination.kept += report.elimination.kept;
    elimination.lost += report.elimination.lost, elimination.removed += report.elimination.removed;
    leaves_deleted += report.deleted, leaves_evicted += report.evicted;
    image_bytes += report.image_bytes;
    scene_bytes = report.sampling.bytes;
    scene_bytes_touched += report.sampling.bytes_touched;
    scene_bytes_touched_most = std::max(scene_bytes_touched_most, report.sampling.bytes_touched);
    sample_ms += report.sample_ms, eliminate_ms += report.eliminate_ms;
    encode_ms += report.encode_ms, insert_ms += report.insert_ms;
}

core::Json status_of(const net::ServerCounts& net, const SessionCounts& s, const SessionMemory& memory) {
    core::Json status = net::to_json(net);
    status.update({{"requests", s.requests},
                   {"requests_refused", s.requests_refused},
                   {"requests_replaced", s.requests_replaced},
                   {"updates", s.updates},
                   {"updates_anew", s.updates_anew},
                   {"samples", s.elimination.samples},
                   {"samples_kept", s.elimination.kept},
                   {"samples_lost", s.elimination.lost},
                   {"points_replaced", s.elimination.removed},
                   {"leaves_deleted", s.leaves_deleted},
                   {"leaves_evicted", s.leaves_evicted},
                   {"session_points", memory.points},
                   {"session_points_limit", memory.most_points},
                   {"session_bytes", memory.bytes},
                   {"scene_bytes", s.scene_bytes},
                   {"scene_bytes_touched", s.scene_bytes_touched},
                   {"scene_bytes_touched_most", s.scene_bytes_touched_most},
                   {"image_bytes", s.image_bytes},
                   {"ms",
                    {{"sample", s.sample_ms},
                     {"eliminate", s.eliminate_ms},
                     {"encode", s.encode_ms},
                     {"insert", s.insert_ms}}}});
    return status;
}

std::string ask_status(const std::string& address, double timeout_s) {
    net::FrameStream stream(net::connect_to(net::parse_address(address), timeout_s), address,
                            kMostMessageBytes);
    const auto said = [&] {
        const auto body = stream.receive(timeout_s);
        if (body.empty())
            throw core::Error(core::text("%s: has not answered for %g s", address.c_str(), timeout_s));
        Message message = parse(body, address);
        if (const auto* refusal = std::get_if<Refusal>(&message))
            throw core::Error(address + ": " + refusal->reason);
        return message;
    };
    const Message first = said();
    if (!std::holds_alternative<Welcome>(first))
        throw core::Error(address + ": its first message is no welcome");
    stream.send(format(StatusQuery{}), timeout_s);
    const Message second = said();
    if (const auto* status = std::get_if<Status>(&second)) return status->counters;
    throw core::Error(address + ": answers a question for its counters by a message that is no answer");
}

}  // namespace ppve
