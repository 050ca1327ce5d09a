// Laying coded trees out as blocks: breadth-first, whole sibling groups, pointers implied.
#pragma once

#include <span>

#include "core/file.h"
#include "splat/build/encode.h"
#include "splat/build/triangle_layout.h"
#include "splat/format.h"

namespace splat {

// The upper tree, whose leaves are the roots of subtrees (child_group -2 - s).
struct CodedModel {
    CodedTree upper;
    std::vector<CodedTree> subtrees;
};

// Fills in block, node, leaf and level counts of `header`, and writes header and blocks.  Group 0 of the
// upper tree are the root's children.  triangles: of a header with kTriangles, else null.
void write_model(const CodedModel& model, const TriangleSource* triangles, Header& header,
                 core::OutputFile& out);

}  // namespace splat
