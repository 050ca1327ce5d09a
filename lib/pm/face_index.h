// Where the surface below each node of a model is bounded: the faces of the input that have one corner below
// it and two elsewhere.  Those of them that a client has are the faces about the node's vertex, so a server
// finds a ring of the client's mesh without keeping the mesh.
//
// Some 30 bytes a face of the input, made in a fraction of a second for a million.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "pm/model.h"

namespace pm {

// Faces are numbered: those of the base mesh, then the left and the right one of each detail.
class FaceIndex {
  public:
    FaceIndex() = default;
    // `roots` are the base vertices in the order of the tree.  `model` outlives it.
    FaceIndex(const Model& model, std::span<const uint32_t> roots);

    // Of a vertex: where its leaf stands in the order of the tree.
    uint32_t rank(uint32_t vertex) const { return rank_[vertex]; }
    bool is_below(uint32_t vertex, uint32_t detail) const {
        return rank_[vertex] - rank_[tree_.kept[detail]] < leaves_[detail];
    }

    // Leaf corners; of a face that is not there kNone.
    const glm::u32vec3& corners(uint32_t face) const {
        if (face < tree_.base_faces.size()) return tree_.base_faces[face];
        const uint32_t f = face - uint32_t(tree_.base_faces.size());
        const SplitFaces& faces = tree_.faces[f / 2];
        return f % 2 == 0 ? faces.left : faces.right;
    }
    // The detail that adds it; kNone: it is of the base mesh.
    uint32_t added_by(uint32_t face) const {
        const uint32_t base = uint32_t(tree_.base_faces.size());
        return face < base ? kNone : (face - base) / 2;
    }

    // All faces that have one corner below the node that a detail splits, and some that have more: those are
    // added by what is split below it.
    std::span<const uint32_t> around(uint32_t detail) const {
        if (leaves_[detail] >= kMostScanned)
            return std::span(wide_).subspan(wide_begin_[detail + 1],
                                            wide_begin_[detail] - wide_begin_[detail + 1]);
        const uint32_t first = rank_[tree_.kept[detail]];
        return std::span(at_leaf_).subspan(leaf_begin_[first],
                                           leaf_begin_[first + leaves_[detail]] - leaf_begin_[first]);
    }

  private:
    // The faces about so many leaves are looked through; for more, lists are kept.
    static constexpr uint32_t kMostScanned = 32;

    void rank_leaves(std::span<const uint32_t> roots, const Model& model);
    void find_faces_at_leaves();
    void list_wide_nodes(const Model& model);

    Hierarchy tree_;
    std::vector<uint32_t> rank_;        // by vertex
    std::vector<uint32_t> leaves_;      // by detail: how many are below its node
    std::vector<uint64_t> leaf_begin_;  // by rank: where in at_leaf_
    std::vector<uint32_t> at_leaf_;     // faces
    std::vector<uint64_t> wide_begin_;  // by detail, the last one first: where in wide_ its list ends
    std::vector<uint32_t> wide_;        // faces
};

}  // namespace pm
