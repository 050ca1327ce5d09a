#include "pm/face_index.h"

namespace pm {

FaceIndex::FaceIndex(const Model& model, std::span<const uint32_t> roots) : tree_(model.hierarchy()) {
    rank_leaves(roots, model);
    find_faces_at_leaves();
    list_wide_nodes(model);
}

void FaceIndex::rank_leaves(std::span<const uint32_t> roots, const Model& model) {
    const auto children = model.children();
    const auto leaves_of = [&](uint32_t detail) { return detail == kNone ? 1 : leaves_[detail]; };
    leaves_.resize(tree_.details());
    for (uint32_t d = tree_.details(); d-- > 0;)
        leaves_[d] = leaves_of(children[d].kept) + leaves_of(children[d].fresh);
    // The first leaf below a node is that of the vertex that its splits keep.
    rank_.resize(tree_.vertices());
    uint32_t next = 0;
    for (const uint32_t root : roots) {
        rank_[root] = next;
        next += leaves_of(model.root_split()[root]);
    }
    for (uint32_t d = 0; d != tree_.details(); ++d)
        rank_[tree_.born_by(d)] = rank_[tree_.kept[d]] + leaves_of(children[d].kept);
}

void FaceIndex::find_faces_at_leaves() {
    const uint32_t faces = uint32_t(tree_.base_faces.size()) + 2 * tree_.details();
    const auto for_each_corner = [&](const auto& use) {
        for (uint32_t f = 0; f != faces; ++f)
            if (const glm::u32vec3& face = corners(f); face.x != kNone)
                for (int i = 0; i != 3; ++i) use(rank_[face[i]], f);
    };
    leaf_begin_.assign(size_t(tree_.vertices()) + 1, 0);
    for_each_corner([&](uint32_t rank, uint32_t) { ++leaf_begin_[rank + 1]; });
    for (uint32_t r = 0; r != tree_.vertices(); ++r) leaf_begin_[r + 1] += leaf_begin_[r];
    at_leaf_.resize(leaf_begin_.back());
    for_each_corner([&](uint32_t rank, uint32_t f) { at_leaf_[leaf_begin_[rank]++] = f; });
    for (uint32_t r = tree_.vertices(); r > 0; --r) leaf_begin_[r] = leaf_begin_[r - 1];
    leaf_begin_[0] = 0;
}

// From those of its children, which stand behind it.
void FaceIndex::list_wide_nodes(const Model& model) {
    wide_begin_.assign(size_t(tree_.details()) + 1, 0);
    for (uint32_t d = tree_.details(); d-- > 0; wide_begin_[d] = wide_.size()) {
        if (leaves_[d] < kMostScanned) continue;
        const auto add = [&](uint32_t face) {
            const glm::u32vec3& at = corners(face);
            if (int(is_below(at.x, d)) + int(is_below(at.y, d)) + int(is_below(at.z, d)) == 1)
                wide_.push_back(face);
        };
        uint32_t leaf = rank_[tree_.kept[d]];
        for (const uint32_t child : {model.children()[d].kept, model.children()[d].fresh}) {
            const uint32_t leaves = child == kNone ? 1 : leaves_[child];
            if (leaves >= kMostScanned)
                for (uint64_t i = wide_begin_[child + 1]; i != wide_begin_[child]; ++i) add(wide_[i]);
            else
                for (uint64_t i = leaf_begin_[leaf]; i != leaf_begin_[leaf + leaves]; ++i) add(at_leaf_[i]);
            leaf += leaves;
        }
    }
    wide_.shrink_to_fit();
}

}  // namespace pm
