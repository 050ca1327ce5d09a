#include "core/file_kind.h"

#include <gtest/gtest.h>

namespace {

std::string sentence_of(std::string_view bytes) {
    return core::is_not_wanted(std::as_bytes(std::span(bytes)), "a splat model", "qs-model");
}

TEST(FileKind, AFileOfAnotherKindIsCalledByItsName) {
    EXPECT_EQ(sentence_of("LASF\1\2"), "a LAS or LAZ cloud of points, not a splat model");
    EXPECT_EQ(sentence_of("ply\r\nformat"), "a PLY file, not a splat model");
    EXPECT_EQ(sentence_of("\x89PNG\r\n\x1a\n"), "a PNG picture, not a splat model");
    EXPECT_EQ(sentence_of("qspmesh\n"), "a progressive mesh, not a splat model");
}

TEST(FileKind, WhatHasNoNameIsToldWhatIsMissing) {
    for (const std::string_view bytes : {"some text", "qs-mod", "p", "plywood"})
        EXPECT_EQ(sentence_of(bytes), "not a splat model (its first bytes are not 'qs-model')") << bytes;
    EXPECT_EQ(sentence_of(""), "empty, not a splat model");
}

}  // namespace
