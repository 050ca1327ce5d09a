// The window: GLFW, and nothing else knows of it.
#pragma once

#include <glm/glm.hpp>
#include <memory>
#include <string>
#include <vector>

#include "gl/device.h"

struct GLFWwindow;

namespace qs_view {

// Places are pixels of the window's picture, from its upper left corner.
class Events {
  public:
    virtual ~Events() = default;
    struct Modifiers {
        bool shift = false, control = false;
    };
    virtual void pressed(int button, const glm::dvec2& px,
                         const Modifiers& with) = 0;  // GLFW_MOUSE_BUTTON_...
    virtual void released(int button) = 0;
    virtual void moved(const glm::dvec2& px) = 0;
    virtual void wheeled(double notches) = 0;
    virtual void key(int key, const Modifiers& with, bool is_repeat) = 0;  // GLFW_KEY_...; pressed
    virtual void character(unsigned code) = 0;
    virtual void dropped(std::vector<std::string> files) = 0;
};

class Window {
  public:
    // Throws core::Error with the system's reason where there is no display, or no OpenGL 3.3.  `events`
    // lives longer.
    Window(const std::string& title, int width, int height, Events& events);
    ~Window();
    Window(const Window&) = delete;
    Window& operator=(const Window&) = delete;

    // Of the calling thread's from now on: what draws into the window.
    const gl::Device& device() const { return *device_; }

    // Waits at most so long for something to happen, and hands it to the events.  From any thread wake() ends
    // it.
    void wait(double timeout_s);
    static void wake();
    bool is_closing() const;
    void close();
    bool is_iconified() const;
    bool is_key_down(int key) const;
    glm::dvec2 mouse_px() const;
    glm::ivec2 size_px() const;
    double scale() const;  // of text
    void set_title(const std::string& title);
    void toggle_full_screen();
    void show_frame();  // what was drawn
    static double time_s();

  private:
    struct Library {
        Library();
        ~Library();
    };
    void listen();

    Library library_;
    GLFWwindow* window_;
    std::unique_ptr<gl::Device> device_;
    glm::ivec4 place_before_full_screen_{0};
};

}  // namespace qs_view
