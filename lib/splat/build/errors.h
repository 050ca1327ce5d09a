// The stored error of each node: a bound on the distance of any point of its disc from the surface.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "splat/build/encode.h"
#include "splat/build/surface.h"

namespace splat {

// Rounds a node's error up to its code and sets it, in the codes and in tree.decoded.
void set_error(CodedTree& tree, size_t node, float error);

// Bound on the distance of a node's disc from the surface, by way of its children, whose errors are known.
float error_over(const Node& node, std::span<const Node* const> children);

// Sets all errors of a coded subtree.  leaf_of: by node, its leaf in the surface, where the node is a leaf.
// Returns the processor time that those of leaves took, milliseconds.
double set_errors(CodedTree& tree, Surface& surface, std::span<const uint32_t> leaf_of);

}  // namespace splat
