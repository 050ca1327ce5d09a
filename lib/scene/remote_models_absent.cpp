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
void RemoteModels::bring(const std::string&, uint64_t) {}
void RemoteModels::place(const std::string&, size_t, uint64_t, uint32_t) {}
void RemoteModels::ask(std::span<const BlockRequest>) {}
bool RemoteModels::wait(double) {
    return false;
}
bool RemoteModels::has_ended() const {
    return true;
}
BlockFetcher::Counters RemoteModels::counters() {
    return {};
}
std::vector<std::string> RemoteModels::news() {
    return {};
}

}  // namespace scene
