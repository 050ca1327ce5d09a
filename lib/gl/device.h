// A context with its functions, and what it says of itself.
#pragma once

#include <memory>
#include <string>

#include "gl/context.h"
#include "gl/functions.h"

namespace gl {

class Device {
  public:
    // Throws core::Error where the context is not good enough.
    explicit Device(std::unique_ptr<Context> context);

    const std::string& renderer() const { return renderer_; }  // GL_RENDERER
    const std::string& version() const { return version_; }    // GL_VERSION
    // A renderer that runs on the CPU, as Mesa's.
    bool is_software() const { return is_software_; }
    int largest_texture() const { return largest_texture_; }  // pixels on a side
    float largest_point() const { return largest_point_; }    // pixels

  private:
    friend class Use;
    std::unique_ptr<Context> context_;
    std::unique_ptr<Functions> functions_;
    std::string renderer_, version_;
    bool is_software_ = false;
    int largest_texture_ = 0;
    float largest_point_ = 0;
};

// Makes a device's context current for as long as it lives, in one thread, and gives access to its functions.
class Use {
  public:
    explicit Use(const Device& device);
    ~Use();
    Use(const Use&) = delete;
    Use& operator=(const Use&) = delete;

    const Functions* operator->() const { return device_.functions_.get(); }
    const Device& device() const { return device_; }

    // Throws core::Error, naming what was done, if GL has had an error since the last check.
    void check(const std::string& what) const;

  private:
    const Device& device_;
};

}  // namespace gl
