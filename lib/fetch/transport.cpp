#include "fetch/transport.h"

#include <curl/curl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/epoll.h>
#include <sys/socket.h>

#include <algorithm>
#include <ctime>
#include <unordered_map>
#include <vector>

#include "fetch/http_fields.h"
#include "fetch/slow_link.h"

namespace fetch {

namespace {

constexpr size_t kMostHeaderBytes = 64 * 1024;
constexpr uint64_t kMostErrorPage = 16 * 1024;  // read to its end for the sake of the connection
constexpr size_t kMostUrlBytes = 8 * 1024;
constexpr size_t kPacketBytes = 1460;  // what passes a slow link at a time
constexpr long kMostRedirects = 5, kConnectMs = 10'000;
constexpr unsigned long long as_llu(uint64_t n) {
    return n;
}

void start_curl() {
    static const CURLcode started = curl_global_init(CURL_GLOBAL_DEFAULT);
    if (started != CURLE_OK) throw core::Error(std::string("libcurl: ") + curl_easy_strerror(started));
}

// As messages begin here: "Couldn't connect", but "SSL connect error".
std::string lower_start(std::string text) {
    if (text.size() > 1 && text[0] >= 'A' && text[0] <= 'Z' && text[1] >= 'a')
        text[0] = char(text[0] + ('a' - 'A'));
    return text;
}

RangeEnd ended(RangeEnd::Verdict verdict, std::string reason) {
    return {verdict, std::move(reason), -1, 0};
}

// A connection whose other end has silently gone is found out in as long as a request that gets nothing.
int set_user_timeout(void* stall_ms, curl_socket_t fd, curlsocktype) {
    ::setsockopt(fd, IPPROTO_TCP, TCP_USER_TIMEOUT, stall_ms, sizeof(unsigned));
    return CURL_SOCKOPT_OK;
}

}  // namespace

std::string server_of(const std::string& url) {
    if (url.size() > kMostUrlBytes) throw core::Error("the URL is longer than 8 KiB");
    if (!std::all_of(url.begin(), url.end(), [](char c) { return c > ' ' && c <= '~'; }))
        throw core::Error("the URL holds characters other than printable ASCII; write them as %20 and so on");
    const std::unique_ptr<CURLU, void (*)(CURLU*)> parsed(curl_url(), curl_url_cleanup);
    const auto part = [&](CURLUPart name, unsigned flags) {
        char* text = nullptr;
        const CURLUcode code = curl_url_get(parsed.get(), name, &text, flags);
        if (code != CURLUE_OK) throw core::Error("is no URL: " + lower_start(curl_url_strerror(code)));
        const std::string copy = text;
        curl_free(text);
        return copy;
    };
    if (const CURLUcode code = curl_url_set(parsed.get(), CURLUPART_URL, url.c_str(), 0); code != CURLUE_OK)
        throw core::Error("is no URL: " + lower_start(curl_url_strerror(code)));
    const std::string scheme = part(CURLUPART_SCHEME, 0);
    if (scheme != "http" && scheme != "https") throw core::Error("is not a URL of http or https");
    std::string host = part(CURLUPART_HOST, 0);
    for (char& c : host)
        if (c >= 'A' && c <= 'Z') c = char(c + ('a' - 'A'));
    return scheme + "://" + host + ":" + part(CURLUPART_PORT, CURLU_DEFAULT_PORT);
}

// One request, from start() until its last byte has passed the slow link.
struct Transport::Transfer {
    State& transport;
    RangeRequest request;
    std::shared_ptr<RangeSink> sink;
    CURL* easy = nullptr;
    curl_slist* lines = nullptr;
    HttpFields fields;
    size_t header_bytes = 0;
    uint64_t expected = 0, got = 0, discarded = 0;
    double last_byte = net::steady_seconds();
    net::EventLoop::TimerId stall_timer = 0;
    long connection = 0;  // its number for the slow link; 0: there is none yet
    double set_up_s = 0;
    bool is_judged = false, is_accepted = false, is_length_sure = false;
    bool may_follow = true;       // redirects
    std::vector<std::byte> held;  // of a body whose length is not sure before its end
    RangeEnd end;

    Transfer(State& state, const RangeRequest& asked, std::shared_ptr<RangeSink> to)
        : transport(state), request(asked), sink(std::move(to)) {}
    ~Transfer() {
        transport_loop().cancel(stall_timer);
        curl_slist_free_all(lines);
    }

    net::EventLoop& transport_loop() const;
    void set_up();
    void set_header_lines();
    void watch_stall();
    void find_connection();
    void judge_header();
    bool take_header(std::string_view line);
    bool take_body(std::span<const std::byte> bytes);
    void hand_on(std::span<const std::byte> bytes);
    void finish(CURLcode code);
    RangeEnd verdict_of_failure(CURLcode code) const;
};

struct Transport::State {
    net::EventLoop& loop;
    TransportOptions options;
    SlowLink link;
    CURLM* multi;
    TransportCounts counts;
    unsigned stall_ms;
    net::EventLoop::TimerId timer = 0;
    std::unordered_map<CURL*, std::unique_ptr<Transfer>> transfers;
    std::vector<CURL*> spare;

    State(net::EventLoop& event_loop, TransportOptions given)
        : loop(event_loop),
          options(std::move(given)),
          link(loop, options.bytes_per_s, options.round_trip_s),
          stall_ms(unsigned(options.stall_s * 1000)) {
        start_curl();
        multi = curl_multi_init();
        if (!multi) throw core::Error("libcurl: cannot be started");
        curl_multi_setopt(multi, CURLMOPT_SOCKETFUNCTION, on_socket);
        curl_multi_setopt(multi, CURLMOPT_SOCKETDATA, this);
        curl_multi_setopt(multi, CURLMOPT_TIMERFUNCTION, on_timer);
        curl_multi_setopt(multi, CURLMOPT_TIMERDATA, this);
        curl_multi_setopt(multi, CURLMOPT_MAX_CONCURRENT_STREAMS, long(options.streams));
        curl_multi_setopt(multi, CURLMOPT_MAXCONNECTS, 64L);
    }
    ~State() {
        for (const auto& [easy, transfer] : transfers) {
            curl_multi_remove_handle(multi, easy);
            curl_easy_cleanup(easy);
        }
        for (CURL* easy : spare) curl_easy_cleanup(easy);
        curl_multi_cleanup(multi);
        loop.cancel(timer);
    }

    static int on_socket(CURL*, curl_socket_t fd, int what, void* self, void*);
    static int on_timer(CURLM*, long ms, void* self);
    void act(curl_socket_t fd, int events);
    void end_finished();
    void end(CURL* easy, CURLcode code);
};

// ---- libcurl's socket interface ----

int Transport::State::on_socket(CURL*, curl_socket_t fd, int what, void* self, void*) {
    State& state = *static_cast<State*>(self);
    if (what == CURL_POLL_REMOVE) {
        state.loop.unwatch(fd);
        return 0;
    }
    const uint32_t events =
        (what & CURL_POLL_IN ? uint32_t{EPOLLIN} : 0) | (what & CURL_POLL_OUT ? uint32_t{EPOLLOUT} : 0);
    state.loop.watch(fd, events, [&state, fd](uint32_t got) {
        int flags = 0;
        if (got & (EPOLLIN | EPOLLHUP)) flags |= CURL_CSELECT_IN;
        if (got & EPOLLOUT) flags |= CURL_CSELECT_OUT;
        if (got & EPOLLERR) flags |= CURL_CSELECT_ERR;
        state.act(fd, flags);
    });
    return 0;
}

int Transport::State::on_timer(CURLM*, long ms, void* self) {
    State& state = *static_cast<State*>(self);
    state.loop.cancel(state.timer);
    state.timer = 0;
    if (ms >= 0)
        state.timer = state.loop.after(double(ms) / 1000, [&state] {
            state.timer = 0;
            state.act(CURL_SOCKET_TIMEOUT, 0);
        });
    return 0;
}

void Transport::State::act(curl_socket_t fd, int events) {
    int running = 0;
    curl_multi_socket_action(multi, fd, events, &running);
    end_finished();
}

void Transport::State::end_finished() {
    int left = 0;
    while (const CURLMsg* message = curl_multi_info_read(multi, &left)) {
        if (message->msg != CURLMSG_DONE) continue;
        end(message->easy_handle, message->data.result);
    }
}

void Transport::State::end(CURL* easy, CURLcode code) {
    const auto found = transfers.find(easy);
    const std::unique_ptr<Transfer> transfer = std::move(found->second);
    transfers.erase(found);
    curl_multi_remove_handle(multi, easy);
    transfer->finish(code);
    spare.push_back(easy);
}

// ---- a transfer ----

net::EventLoop& Transport::Transfer::transport_loop() const {
    return transport.loop;
}

void Transport::Transfer::set_up() {
    const TransportOptions& options = transport.options;
    const auto set = [&](CURLoption option, auto value) { curl_easy_setopt(easy, option, value); };
    curl_easy_reset(easy);
    const bool is_https = request.url.starts_with("https:");
    set(CURLOPT_URL, request.url.c_str());
    set(CURLOPT_PROTOCOLS_STR, "http,https");
    set(CURLOPT_REDIR_PROTOCOLS_STR, is_https ? "https" : "http,https");
    set(CURLOPT_MAXREDIRS, kMostRedirects);
    set(CURLOPT_HTTP_VERSION, long(CURL_HTTP_VERSION_2TLS));
    set(CURLOPT_PIPEWAIT, is_https ? 1L : 0L);
    set(CURLOPT_HTTP09_ALLOWED, 0L);
    set(CURLOPT_NOSIGNAL, 1L);
    set(CURLOPT_NETRC, long(CURL_NETRC_OPTIONAL));
    set(CURLOPT_CONNECTTIMEOUT_MS, kConnectMs);
    set(CURLOPT_SOCKOPTFUNCTION, set_user_timeout);
    set(CURLOPT_SOCKOPTDATA, &transport.stall_ms);
    set(CURLOPT_BUFFERSIZE, 128L * 1024);
    set(CURLOPT_USERAGENT, options.user_agent.c_str());
    if (!options.ca_file.empty()) set(CURLOPT_CAINFO, options.ca_file.c_str());
    set(CURLOPT_RANGE, core::text("%llu-%llu", as_llu(request.first), as_llu(request.last)).c_str());
    set_header_lines();
    using Callback = size_t (*)(char*, size_t, size_t, void*);
    const Callback header = [](char* data, size_t, size_t size, void* self) -> size_t {
        return static_cast<Transfer*>(self)->take_header({data, size}) ? size : 0;
    };
    const Callback body = [](char* data, size_t, size_t size, void* self) -> size_t {
        return static_cast<Transfer*>(self)->take_body(std::as_bytes(std::span(data, size))) ? size : 0;
    };
    set(CURLOPT_HEADERFUNCTION, header);
    set(CURLOPT_HEADERDATA, this);
    set(CURLOPT_WRITEFUNCTION, body);
    set(CURLOPT_WRITEDATA, this);
}

void Transport::Transfer::set_header_lines() {
    const auto add = [&](const std::string& line) { lines = curl_slist_append(lines, line.c_str()); };
    add("Accept-Encoding: identity");
    if (const std::string condition = request.condition(); !condition.empty()) add(condition);
    const std::vector<std::string> given = transport.options.header_rules.fields_for(request.url);
    for (const std::string& field : given) add(field);
    curl_easy_setopt(easy, CURLOPT_HTTPHEADER, lines);
    // libcurl would carry them on to another server.
    may_follow = given.empty();
    curl_easy_setopt(easy, CURLOPT_FOLLOWLOCATION, long(may_follow));
}

void Transport::Transfer::watch_stall() {
    const double left = last_byte + transport.options.stall_s - net::steady_seconds();
    stall_timer = transport.loop.after(std::max(0.0, left), [this, left] {
        stall_timer = 0;
        if (left <= 0)
            transport.end(easy, CURLE_OPERATION_TIMEDOUT);
        else
            watch_stall();
    });
}

bool Transport::Transfer::take_header(std::string_view line) {
    last_byte = net::steady_seconds();
    header_bytes += line.size();
    if (header_bytes > kMostHeaderBytes) {
        end = ended(RangeEnd::Verdict::refused, "server sent more than 64 KiB of header");
        is_judged = true;
        return false;
    }
    fields.take_line(line, ::time(nullptr));
    return true;
}

// Connections are told apart by their ports here.
void Transport::Transfer::find_connection() {
    long made = 0;
    curl_easy_getinfo(easy, CURLINFO_LOCAL_PORT, &connection);
    curl_easy_getinfo(easy, CURLINFO_NUM_CONNECTS, &made);
    if (made > 0) transport.link.connect(connection, request.url.starts_with("https:") ? 2 : 1);
    curl_off_t before_us = 0;
    curl_easy_getinfo(easy, CURLINFO_PRETRANSFER_TIME_T, &before_us);
    set_up_s = double(before_us) / 1e6 + transport.link.until_open_s(connection);
}

void Transport::Transfer::judge_header() {
    is_judged = true;
    find_connection();
    curl_off_t length = -1;
    curl_easy_getinfo(easy, CURLINFO_CONTENT_LENGTH_DOWNLOAD_T, &length);
    is_length_sure = length >= 0;
    Judgement judgement =
        judge(request, fields, is_length_sure ? std::optional(uint64_t(length)) : std::nullopt);
    is_accepted = judgement.is_accepted;
    expected = judgement.expected;
    end = std::move(judgement.end);
    if (fields.status / 100 == 3 && !may_follow)
        end.reason += "; no redirect is followed where --headers has a line";
    if (!is_accepted) return;
    const RangeHead head{fields.content_range->total, fields.validator, fields.content_range->last,
                         header_bytes, set_up_s};
    transport.link.pass(connection, header_bytes, [to = sink, head] { to->head(head); });
}

bool Transport::Transfer::take_body(std::span<const std::byte> bytes) {
    last_byte = net::steady_seconds();
    if (!is_judged) judge_header();
    if (!is_accepted) {
        discarded += bytes.size();
        const bool is_whole_file = fields.status == 200 || fields.status == 206;
        return !is_whole_file && discarded <= kMostErrorPage;
    }
    got += bytes.size();
    if (got > expected) {
        end = ended(RangeEnd::Verdict::refused,
                    core::text("server sent more than the %llu bytes of the range", as_llu(expected)));
        return false;
    }
    if (is_length_sure)
        hand_on(bytes);
    else
        held.insert(held.end(), bytes.begin(), bytes.end());
    return true;
}

void Transport::Transfer::hand_on(std::span<const std::byte> bytes) {
    transport.counts.body_bytes += bytes.size();
    if (!transport.link.is_slow()) {
        sink->bytes(bytes);
        return;
    }
    for (; !bytes.empty(); bytes = bytes.subspan(std::min(bytes.size(), kPacketBytes))) {
        const auto packet = bytes.first(std::min(bytes.size(), kPacketBytes));
        transport.link.pass(
            connection, packet.size(),
            [to = sink, copy = std::vector<std::byte>(packet.begin(), packet.end())] { to->bytes(copy); });
    }
}

RangeEnd Transport::Transfer::verdict_of_failure(CURLcode code) const {
    const std::string reason = lower_start(curl_easy_strerror(code));
    switch (code) {
        case CURLE_TOO_MANY_REDIRECTS:
            return ended(RangeEnd::Verdict::refused,
                         core::text("server redirects more than %ld times", kMostRedirects));
        case CURLE_UNSUPPORTED_PROTOCOL:
            return ended(RangeEnd::Verdict::refused,
                         "server redirects to what is not http or https, or from https to http");
        case CURLE_PEER_FAILED_VERIFICATION:
            return ended(RangeEnd::Verdict::refused, "the server's certificate is not to be trusted");
        case CURLE_PARTIAL_FILE:
        case CURLE_GOT_NOTHING:
            return ended(RangeEnd::Verdict::retry, "server ended the answer too early");
        case CURLE_SSL_CACERT_BADFILE:
        case CURLE_SSL_ISSUER_ERROR:
        case CURLE_URL_MALFORMAT:
        case CURLE_WEIRD_SERVER_REPLY:
            return ended(RangeEnd::Verdict::refused, reason);
        case CURLE_OPERATION_TIMEDOUT:
            return ended(RangeEnd::Verdict::retry,
                         core::text("server sent nothing for %.3g s", transport.options.stall_s));
        default:
            return ended(RangeEnd::Verdict::retry, reason);
    }
}

void Transport::Transfer::finish(CURLcode code) {
    if (!is_judged && fields.status != 0 && code == CURLE_OK) judge_header();
    if (is_accepted && code == CURLE_OK && got == expected) {
        hand_on(held);
    } else if (!is_judged || (is_accepted && end.verdict == RangeEnd::Verdict::done)) {
        end = verdict_of_failure(code == CURLE_OK ? CURLE_PARTIAL_FILE : code);
    }
    long version = 0;
    curl_easy_getinfo(easy, CURLINFO_HTTP_VERSION, &version);
    if (version >= CURL_HTTP_VERSION_2_0)
        end.streams = transport.options.streams, end.connections = 1;
    else if (version != 0)
        end.streams = end.connections = transport.options.connections;
    transport.counts.header_bytes += header_bytes;
    // A refusal passes the link too, or it would come before what was asked for earlier.
    transport.link.pass(connection, is_accepted ? 0 : header_bytes,
                        [to = std::move(sink), end = std::move(end)] { to->end(end); });
}

// ---- Transport ----

Transport::Transport(net::EventLoop& loop, TransportOptions options)
    : state_(std::make_unique<State>(loop, std::move(options))) {}

Transport::~Transport() = default;

void Transport::start(const RangeRequest& request, std::shared_ptr<RangeSink> sink) {
    State& state = *state_;
    CURL* easy = nullptr;
    if (state.spare.empty()) {
        easy = curl_easy_init();
        if (!easy) throw core::Error("libcurl: out of memory");
    } else {
        easy = state.spare.back();
        state.spare.pop_back();
    }
    auto transfer = std::make_unique<Transfer>(state, request, std::move(sink));
    transfer->easy = easy;
    transfer->set_up();
    transfer->watch_stall();
    ++state.counts.requests;
    state.transfers[easy] = std::move(transfer);
    curl_multi_add_handle(state.multi, easy);
}

const TransportCounts& Transport::counts() const {
    return state_->counts;
}

}  // namespace fetch
