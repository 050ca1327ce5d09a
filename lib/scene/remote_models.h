// Models at web servers, through the cache daemon of qs-fetch.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "scene/block_fetcher.h"
#include "splat/block_source.h"
#include "splat/model.h"

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
    // Waits for what a first picture needs of a file that is open.
    void bring_first_picture(const std::string& url);
    // Waits for the first `blocks` of the model of `url`; what a first picture needs is asked for with them.
    void bring_blocks(const std::string& url, const splat::Model& model, uint64_t blocks);
    // That the model of `url`, which lives as long as this is asked, is at this place among those that are
    // drawn.
    void place(const std::string& url, size_t place, const splat::Model& model);

    void ask(std::span<const BlockRequest> requests) override;
    bool wait(double timeout_s) override;
    bool has_ended() const override;
    uint64_t most_bytes(const BlockRequest& request) const override;
    Counters counters() override;

    // What the user is to be told about the files, each once: that one was replaced, what is tried again.
    std::vector<std::string> news();

  private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace scene
