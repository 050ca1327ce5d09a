#include "pm/welds.h"

#include <algorithm>
#include <tuple>

namespace pm {

namespace {

auto key_of(const glm::u32vec3& place) {
    return std::tuple(place.x, place.y, place.z);
}

// The vertices of welds, and by each the lowest one that welds lead to.
class Groups {
  public:
    explicit Groups(std::span<const Weld> welds) {
        for (const Weld& weld : welds) vertices_.push_back(weld.copy), vertices_.push_back(weld.of);
        std::sort(vertices_.begin(), vertices_.end());
        vertices_.erase(std::unique(vertices_.begin(), vertices_.end()), vertices_.end());
        up_.resize(vertices_.size());
        for (size_t i = 0; i != up_.size(); ++i) up_[i] = i;
        for (const Weld& weld : welds) {
            const size_t a = find(place_of(weld.copy)), b = find(place_of(weld.of));
            up_[std::max(a, b)] = std::min(a, b);
        }
    }
    std::span<const uint32_t> vertices() const { return vertices_; }
    uint32_t lowest(size_t i) { return vertices_[find(i)]; }

  private:
    size_t place_of(uint32_t vertex) const {
        return size_t(std::lower_bound(vertices_.begin(), vertices_.end(), vertex) - vertices_.begin());
    }
    size_t find(size_t i) {
        while (up_[i] != i) i = up_[i] = up_[up_[i]];
        return i;
    }

    std::vector<uint32_t> vertices_;  // rising
    std::vector<size_t> up_;
};

}  // namespace

WeldNumbers::WeldNumbers(std::span<const Weld> welds, const std::function<glm::u32vec3(uint32_t)>& place) {
    struct Member {
        glm::u32vec3 place;
        uint32_t group, vertex;
        auto key() const { return std::tuple(key_of(place), group, vertex); }
    };
    Groups groups(welds);
    std::vector<Member> members;
    for (size_t i = 0; i != groups.vertices().size(); ++i) {
        const uint32_t vertex = groups.vertices()[i];
        members.push_back({place(vertex), groups.lowest(i), vertex});
    }
    std::sort(members.begin(), members.end(),
              [](const Member& a, const Member& b) { return a.key() < b.key(); });
    uint16_t number = 0;
    for (size_t i = 0; i != members.size(); ++i) {
        const Member& member = members[i];
        if (i == 0 || members[i - 1].place != member.place)
            number = 1;
        else if (members[i - 1].group != member.group && number < kMostWeldNumber)
            ++number;
        numbers_.emplace_back(member.vertex, number);
    }
    std::sort(numbers_.begin(), numbers_.end());
}

uint16_t WeldNumbers::operator[](uint32_t vertex) const {
    const auto found = std::lower_bound(numbers_.begin(), numbers_.end(), std::pair(vertex, uint16_t(0)));
    return found != numbers_.end() && found->first == vertex ? found->second : uint16_t(0);
}

void join_welded(std::vector<WeldedVertex>& shown, std::span<uint32_t> as) {
    const auto group_of = [](const WeldedVertex& w) { return std::tuple(key_of(w.place), w.number); };
    std::sort(shown.begin(), shown.end(), [&](const WeldedVertex& a, const WeldedVertex& b) {
        return std::tuple(group_of(a), a.vertex) < std::tuple(group_of(b), b.vertex);
    });
    for (size_t i = 1; i < shown.size(); ++i)
        if (group_of(shown[i]) == group_of(shown[i - 1])) as[shown[i].vertex] = as[shown[i - 1].vertex];
}

}  // namespace pm
