// Models at web servers, through the cache daemon of qs-fetch.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "scene/block_fetcher.h"
#include "splat/block_source.h"

namespace scene {

inline bool is_url(const std::string& name) {  // of http or https
    return name.starts_with("http://") || name.starts_with("https://");
}

class RemoteModels final : public BlockFetcher {
  public:
    // `cache`: the daemon's folder; empty: qs-fetch's default.  A daemon is started where none runs:
    // `program`, or qs-fetch beside this program, or on the path.  Throws core::Error where that cannot be,
    // or the program was built without.
    explicit RemoteModels(const std::string& cache);
    ~RemoteModels() override;

    // What two round trips bring, and a first complete picture of a model of any size.
    static constexpr uint64_t kFirstPictureBytes = 13 * 1024;

    // Waits for the header of a model.  The source lives no longer than this.  Throws core::Error with the
    // reason where it cannot be had.
    std::unique_ptr<const splat::BlockSource> open(const std::string& url);
    // Waits for the first `bytes` of a file that is open; what a first picture needs is asked for with them.
    void bring(const std::string& url, uint64_t bytes);
    // That the model of `url` is at this place among those that are drawn, for ask().
    void place(const std::string& url, size_t model, uint64_t first_block_offset, uint32_t block_bytes);

    void ask(std::span<const BlockRequest> requests) override;
    bool wait(double timeout_s) override;
    bool has_ended() const override;
    Counters counters() override;

    // What the user is to be told about the files, each once: that one was replaced, what is tried again.
    std::vector<std::string> news();

  private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace scene
