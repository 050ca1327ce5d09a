// A client of a server of progressive meshes: what a program needs to follow views over a network.
//
//     pm::Client client(net::FrameStream(...));
//     client.open("dragon");
//     client.look_at(view);                      // as often as wanted, takes the place of the earlier ones
//     while (!client.is_complete()) client.wait(0.02);
//     const pm::Front& front = client.refine();  // what it has for the last view, refined and coarsened
//
// The server is asked only where the view lacks something: the second time round, nothing is sent either way.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "net/frame_stream.h"
#include "pm/front.h"
#include "pm/lists.h"
#include "pm/messages.h"
#include "pm/one_way.h"
#include "pm/replica.h"
#include "pm/split_code.h"

namespace pm {

// What a client has, to be kept in a file and gone on with later, by whatever connection.
class ClientState {
  public:
    ClientState(const std::array<std::byte, kHeaderSize>& header, std::vector<std::byte> base_packet,
                Service service = Service::selective);

    const Header& header() const { return replica_->header(); }
    Service service() const { return service_; }
    Replica& replica() { return *replica_; }
    const Replica& replica() const { return *replica_; }
    uint64_t hash() const { return model_hash(replica_->header()); }

    // A file of its own: pm-protocol(5).  Throws core::Error "<name>: ..." where the bytes are none, whatever
    // they are.
    std::vector<std::byte> to_bytes() const;
    static ClientState from_bytes(std::span<const std::byte> bytes, const std::string& name);

  private:
    std::array<std::byte, kHeaderSize> header_bytes_;
    std::vector<std::byte> base_packet_;
    Service service_;
    std::unique_ptr<Replica> replica_;
};

struct ClientCounts {
    uint64_t requests_sent = 0, packets = 0, splits = 0;
};

// Not thread-safe.
class Client {
  public:
    // A request that is not answered within `timeout_s` is an Error.
    explicit Client(net::FrameStream stream, double timeout_s = 60);
    ~Client();

    // Asks for a model.  Throws core::Error with the server's reason.
    void open(const std::string& name, Service service = Service::selective);
    // Goes on with what was received by an earlier connection, by the same service.
    void resume(const std::string& name, ClientState state);

    // JSON, as in pm-serve(1).
    std::string status() { return ask(RequestKind::status); }
    std::string catalogue() { return ask(RequestKind::catalogue); }

    // True where something is lacking, and the server was told; or may be lacking, one way.
    bool look_at(const View& view, Culling culling = Culling::on);
    // All that the last view wants is here.
    bool is_complete() const { return sent_.empty(); }
    // Takes packets that have come, and waits until one does.  False where none did in this time.  Throws
    // core::Error with the server's reason, and where packets are wrong, and net::ConnectionLost.
    bool wait(double timeout_s);

    // The front that the last view wants, of what is here; one way all that is here.  Valid until the next
    // call of wait().
    const Front& refine();

    const ClientState& state() const { return *state_; }
    ClientState take_state() { return std::move(*state_); }
    const ClientCounts& counts() const { return counts_; }
    const net::FrameStream& stream() const { return stream_; }

  private:
    struct Sought {
        View view;
        Culling culling;
        bool operator==(const Sought&) const = default;
    };
    void begin(ClientState state);
    Reply expect(ReplyKind kind);
    std::string ask(RequestKind kind);
    void send(Request request);
    std::unique_ptr<Sweep<Replica>> make_sweep(const Sought& sought) const;
    bool ask_for_view();
    bool ask_for_list();
    void take(const Reply& packet);
    void begin_answer(const Sought& sought);
    void take_decisions(const Reply& packet);

    net::FrameStream stream_;
    double timeout_s_;
    std::unique_ptr<ClientState> state_;
    std::unique_ptr<SplitModels> models_;
    // Of what is being answered, answer_number_, one of these, by the service, as far as packets have come.
    std::unique_ptr<Sweep<Replica>> sweep_;
    std::unique_ptr<PassCursor<Replica>> passes_;
    std::vector<uint32_t> listed_;  // nodes
    uint32_t answer_number_ = 0, number_ = 0;
    std::map<uint32_t, Sought> sent_;  // what was sent and not answered to its end
    Sought last_{};
    std::optional<Sought> answered_;  // the last view that was, to its end
    std::unique_ptr<Front> front_;
    ClientCounts counts_;
};

}  // namespace pm
