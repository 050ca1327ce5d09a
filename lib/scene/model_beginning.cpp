#include "scene/model_beginning.h"

#include <algorithm>
#include <span>

#include "scene/remote_models.h"
#include "splat/model.h"

namespace scene {

core::InputFile open_beginning(const std::string& url, const std::string& cache) {
    RemoteModels remote(cache);
    const splat::Model model(remote.open(url));
    remote.bring_first_picture(url);
    remote.bring_blocks(url, model, 1);
    const uint64_t size = std::min<uint64_t>(
        std::max(RemoteModels::kFirstPictureBytes, model.prefix_bytes(0)), model.size_bytes());
    core::OutputFile copy(core::OutputFile::InMemory{url});
    copy.write(std::span(remote.open(url)->data(), size));
    return copy.read_back();
}

}  // namespace scene
