#include "gl/device.h"

#include "core/error.h"
#include "frames.h"
#include "gl/library.h"
#include "gl/objects.h"

namespace {

class Device : public testing::TestWithParam<const char*> {
  protected:
    void SetUp() override {
        std::string reason;
        device_ = gl_test::open(GetParam(), reason);
        if (!device_) GTEST_SKIP() << reason;
    }
    std::unique_ptr<gl::Device> device_;
};

}  // namespace

TEST_P(Device, SaysWhatItIs) {
    EXPECT_FALSE(device_->renderer().empty());
    EXPECT_NE(device_->version().find('.'), std::string::npos);
    EXPECT_GE(device_->largest_texture(), 1024);
    EXPECT_GE(device_->largest_point(), 1.0f);
    if (std::string(GetParam()) == "osmesa") {
        EXPECT_TRUE(device_->is_software()) << device_->renderer();
    }
}

TEST_P(Device, PassesOnWhatTheDriverSaysOfAShader) {
    const gl::Use gl(*device_);
    try {
        gl::make_program(gl, "#version 330 core\nvoid main() { no_such_function(); }\n",
                         "#version 330 core\nvoid main() {}\n");
        ADD_FAILURE() << "took it";
    } catch (const core::Error& error) {
        EXPECT_NE(std::string(error.what()).find("no_such_function"), std::string::npos) << error.what();
        EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
    }
}

TEST_P(Device, ReportsErrorsWithWhatWasDone) {
    const gl::Use gl(*device_);
    gl->Enable(0xffff);
    EXPECT_THROW(
        {
            try {
                gl.check("asking too much");
            } catch (const core::Error& error) {
                EXPECT_NE(std::string(error.what()).find("invalid enum while asking too much"),
                          std::string::npos);
                throw;
            }
        },
        core::Error);
    EXPECT_NO_THROW(gl.check("nothing"));
}

// Two in turn, in one thread: each draws into what is its own.
TEST_P(Device, LivesBesideAnother) {
    std::string reason;
    const std::unique_ptr<gl::Device> other = gl_test::open(GetParam(), reason);
    ASSERT_TRUE(other) << reason;
    const auto draw = [](const gl::Device& device, GLuint value) {
        const gl::Use gl(device);
        gl::Texture texture(gl, gl::kUints2);
        texture.grow(gl, 2, 2);
        gl::Framebuffer(gl, {&texture}, nullptr).bind(gl);
        const GLuint values[4] = {value, value, 0, 0};
        gl->ClearBufferuiv(GL_COLOR, 0, values);
        GLuint read[8] = {};
        gl->ReadPixels(0, 0, 2, 2, gl::kUints2.format, gl::kUints2.type, read);
        gl.check("drawing");
        EXPECT_EQ(read[0], value);
        EXPECT_EQ(read[7], value);
    };
    for (GLuint value = 1; value < 4; ++value) draw(*device_, value), draw(*other, 10 * value);
}

INSTANTIATE_TEST_SUITE_P(Contexts, Device, testing::ValuesIn(gl_test::kContexts));

TEST(Library, SaysWhatCannotBeLoadedAndWhereItIs) {
    try {
        const gl::Library library("libno-such-thing.so.7", "libno-such-thing7");
        ADD_FAILURE();
    } catch (const core::Error& error) {
        const std::string what = error.what();
        EXPECT_NE(what.find("libno-such-thing.so.7"), std::string::npos) << what;
        EXPECT_NE(what.find("libno-such-thing7"), std::string::npos) << what;
    }
}

TEST(Parts, CoverThePictureOnce) {
    for (const int width : {1, 5, 6, 7, 13}) {
        std::vector<int> count(size_t(width) * 11, 0);
        for (const gl::Part& part : gl::parts_of(width, 11, 6)) {
            EXPECT_LE(part.width, 6);
            EXPECT_LE(part.height, 6);
            for (int y = part.y; y < part.y + part.height; ++y)
                for (int x = part.x; x < part.x + part.width; ++x) ++count[size_t(y * width + x)];
        }
        EXPECT_EQ(count, std::vector<int>(count.size(), 1));
    }
}
