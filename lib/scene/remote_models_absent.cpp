#include "core/error.h"
#include "scene/remote_models.h"

namespace scene {

struct RemoteModels::State {};

RemoteModels::RemoteModels(const std::string&) {
    throw core::Error("this program was built without fetching (-DQS_FETCH=OFF); get the model as a file");
}
RemoteModels::~RemoteModels() = default;
std::unique_ptr<const splat::BlockSource> RemoteModels::open(const std::string&) {
    return nullptr;
}
void RemoteModels::bring_first_picture(const std::string&) {}
void RemoteModels::bring_blocks(const std::string&, const splat::Model&, uint64_t) {}
void RemoteModels::place(const std::string&, size_t, const splat::Model&) {}
void RemoteModels::ask(std::span<const BlockRequest>) {}
bool RemoteModels::wait(double) {
    return false;
}
bool RemoteModels::has_ended() const {
    return true;
}
uint64_t RemoteModels::most_bytes(const BlockRequest&) const {
    return 0;
}
BlockFetcher::Counters RemoteModels::counters() {
    return {};
}
std::vector<std::string> RemoteModels::news() {
    return {};
}

}  // namespace scene
