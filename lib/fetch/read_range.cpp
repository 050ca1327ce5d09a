#include "fetch/read_range.h"

#include <algorithm>

#include "net/event_loop.h"

namespace fetch {

namespace {

constexpr uint64_t kAhead = 7000;  // blocks: what fits into one message
// A want costs the daemon a look at all of it: so rarely, while much comes.
constexpr double kBetweenWants = 0.02, kBetweenLooks = 0.002;

class Reading {
  public:
    Reading(Connection& connection, RemoteFile& file, const std::string& url, uint64_t first, uint64_t last)
        : connection_(connection),
          file_(file),
          url_(url),
          first_(first),
          last_(last),
          block_(uint32_t(first / file.block_bytes())),
          end_(uint32_t(last / file.block_bytes()) + 1) {}

    void run(double timeout_s, const std::function<void(std::span<const std::byte>)>& take) {
        double last_progress = net::steady_seconds(), last_want = 0;
        uint32_t wanted_at = block_;
        bool is_told = true;
        for (;;) {
            const uint32_t before = block_;
            take_present(take);
            if (block_ == end_) return;
            if (!file_.failure().empty()) throw core::Error(url_ + ": " + file_.failure());
            const double now = net::steady_seconds();
            if (block_ != before) last_progress = now;
            if (now - last_progress > timeout_s) fail_by_time(timeout_s);
            if (!is_told) {
                is_told = connection_.wait(std::min(1.0, timeout_s));
            } else if (block_ - wanted_at >= kAhead / 4 || now - last_want > kBetweenWants) {
                is_told = !want();
                wanted_at = block_;
                last_want = now;
            } else {
                connection_.wait(block_ != before ? kBetweenLooks : kBetweenWants);
            }
        }
    }

  private:
    void take_present(const std::function<void(std::span<const std::byte>)>& take) {
        for (; block_ != end_; ++block_) {
            const std::span<const std::byte> bytes = file_.block(block_);
            if (bytes.empty()) return;
            const uint64_t begin = uint64_t{block_} * file_.block_bytes();
            const uint64_t from = std::max(begin, first_), to = std::min(begin + bytes.size(), last_ + 1);
            take(bytes.subspan(size_t(from - begin), size_t(to - from)));
        }
    }

    bool want() {
        std::vector<Want> wants;
        for (uint64_t block = block_; block < std::min<uint64_t>(end_, block_ + kAhead); ++block)
            if (file_.block(uint32_t(block)).empty()) wants.push_back({uint32_t(block), 1});
        return file_.want(std::move(wants));
    }

    [[noreturn]] void fail_by_time(double timeout_s) const {
        const std::string why = file_.trouble().empty() ? "" : "; " + file_.trouble();
        throw core::Error(url_ + core::text(": nothing has come for %.0f s", timeout_s) + why);
    }

    Connection& connection_;
    RemoteFile& file_;
    const std::string& url_;
    uint64_t first_, last_;
    uint32_t block_, end_;
};

}  // namespace

void read_range(Connection& connection, RemoteFile& file, const std::string& url, uint64_t first,
                uint64_t last, double timeout_s,
                const std::function<void(std::span<const std::byte>)>& take) {
    Reading(connection, file, url, first, last).run(timeout_s, take);
}

}  // namespace fetch
