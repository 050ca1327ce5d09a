#include "qs-view/window.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include <algorithm>

#include "core/error.h"

// Drivers of OpenGL leave some bytes to whoever unloads them; the sanitizer finds those only while they are
// loaded.
#ifdef __SANITIZE_ADDRESS__
#include <dlfcn.h>
extern "C" int dlclose(void*) noexcept {
    return 0;
}
#endif

namespace qs_view {

namespace {

std::string last_error = "unknown reason";  // GLFW tells it to a function without a place of its own

class WindowContext final : public gl::Context {
  public:
    explicit WindowContext(GLFWwindow* window) : window_(window) {}
    void make_current() override { glfwMakeContextCurrent(window_); }
    void release() override { glfwMakeContextCurrent(nullptr); }
    void* function(const char* name) const override {
        return reinterpret_cast<void*>(glfwGetProcAddress(name));
    }

  private:
    GLFWwindow* window_;
};

Events& events_of(GLFWwindow* window) {
    return *static_cast<Events*>(glfwGetWindowUserPointer(window));
}

Events::Modifiers modifiers(int mods) {
    return {(mods & GLFW_MOD_SHIFT) != 0, (mods & GLFW_MOD_CONTROL) != 0};
}

// The mouse is told of in the window's units, of which a pixel may be a part.
glm::dvec2 in_pixels(GLFWwindow* window, double x, double y) {
    int width = 1, height = 1, width_px = 1, height_px = 1;
    glfwGetWindowSize(window, &width, &height);
    glfwGetFramebufferSize(window, &width_px, &height_px);
    return {x * width_px / std::max(width, 1), y * height_px / std::max(height, 1)};
}

GLFWwindow* make_window(const std::string& title, int width, int height) {
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    glfwWindowHint(GLFW_OPENGL_FORWARD_COMPAT, GLFW_TRUE);
    glfwWindowHint(GLFW_DEPTH_BITS, 0);
    glfwWindowHint(GLFW_STENCIL_BITS, 0);
    GLFWwindow* const window = glfwCreateWindow(width, height, title.c_str(), nullptr, nullptr);
    if (!window) throw core::Error("no window with OpenGL 3.3 can be opened: " + last_error);
    return window;
}

}  // namespace

Window::Library::Library() {
    glfwSetErrorCallback([](int, const char* description) { last_error = description; });
    if (!glfwInit())
        throw core::Error("no window can be opened: " + last_error + "; qs-render draws without one");
}

Window::Library::~Library() {
    glfwTerminate();
}

Window::Window(const std::string& title, int width, int height, Events& events)
    : window_(make_window(title, width, height)),
      device_(std::make_unique<gl::Device>(std::make_unique<WindowContext>(window_))) {
    glfwSetWindowUserPointer(window_, &events);
    listen();
}

Window::~Window() {
    device_.reset();
    glfwDestroyWindow(window_);
}

void Window::listen() {
    glfwSetMouseButtonCallback(window_, [](GLFWwindow* w, int button, int action, int mods) {
        double x = 0, y = 0;
        glfwGetCursorPos(w, &x, &y);
        if (action == GLFW_PRESS)
            events_of(w).pressed(button, in_pixels(w, x, y), modifiers(mods));
        else
            events_of(w).released(button);
    });
    glfwSetCursorPosCallback(
        window_, [](GLFWwindow* w, double x, double y) { events_of(w).moved(in_pixels(w, x, y)); });
    glfwSetScrollCallback(window_,
                          [](GLFWwindow* w, double, double notches) { events_of(w).wheeled(notches); });
    glfwSetKeyCallback(window_, [](GLFWwindow* w, int key, int, int action, int mods) {
        if (action != GLFW_RELEASE) events_of(w).key(key, modifiers(mods), action == GLFW_REPEAT);
    });
    glfwSetCharCallback(window_, [](GLFWwindow* w, unsigned code) { events_of(w).character(code); });
    glfwSetDropCallback(window_, [](GLFWwindow* w, int count, const char** files) {
        events_of(w).dropped(std::vector<std::string>(files, files + count));
    });
}

void Window::wait(double timeout_s) {
    glfwWaitEventsTimeout(timeout_s);
}

void Window::wake() {
    glfwPostEmptyEvent();
}

bool Window::is_closing() const {
    return glfwWindowShouldClose(window_);
}

void Window::close() {
    glfwSetWindowShouldClose(window_, GLFW_TRUE);
}

bool Window::is_iconified() const {
    return glfwGetWindowAttrib(window_, GLFW_ICONIFIED) || !glfwGetWindowAttrib(window_, GLFW_VISIBLE);
}

bool Window::is_key_down(int key) const {
    return glfwGetKey(window_, key) == GLFW_PRESS;
}

glm::dvec2 Window::mouse_px() const {
    double x = 0, y = 0;
    glfwGetCursorPos(window_, &x, &y);
    return in_pixels(window_, x, y);
}

glm::ivec2 Window::size_px() const {
    glm::ivec2 size(1);
    glfwGetFramebufferSize(window_, &size.x, &size.y);
    return glm::max(size, glm::ivec2(1));
}

double Window::scale() const {
    float x = 1, y = 1;
    glfwGetWindowContentScale(window_, &x, &y);
    return std::max(1.0, double(y));
}

void Window::set_title(const std::string& title) {
    glfwSetWindowTitle(window_, title.c_str());
}

void Window::toggle_full_screen() {
    glm::ivec4& place = place_before_full_screen_;
    if (glfwGetWindowMonitor(window_)) {
        glfwSetWindowMonitor(window_, nullptr, place.x, place.y, place.z, place.w, GLFW_DONT_CARE);
        return;
    }
    GLFWmonitor* const monitor = glfwGetPrimaryMonitor();
    if (!monitor) return;
    const GLFWvidmode* const mode = glfwGetVideoMode(monitor);
    glfwGetWindowPos(window_, &place.x, &place.y);
    glfwGetWindowSize(window_, &place.z, &place.w);
    glfwSetWindowMonitor(window_, monitor, 0, 0, mode->width, mode->height, mode->refreshRate);
}

void Window::show_frame() {
    glfwSwapBuffers(window_);
}

double Window::time_s() {
    return glfwGetTime();
}

}  // namespace qs_view
