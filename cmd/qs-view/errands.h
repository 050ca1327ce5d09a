// Files written beside the window, which does not wait for disks.
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace qs_view {

class Errands {
  public:
    // `on_done`: called from the errands' thread; must not wait.
    explicit Errands(std::function<void()> on_done);
    ~Errands();  // does what is left first

    // `make` has the bytes; called in the errands' thread.  Without a name a new file is made:
    // qs-view-0001.ENDING, or the first number that there is no file of.
    void write(const std::string& name, const std::string& ending, std::function<std::string()> make);

    // What was done or went wrong since the last call, a sentence each; those that went wrong are told to
    // core::fail(), too.
    std::vector<std::string> news();
    // Waits until all is done.
    void finish();

  private:
    struct Errand {
        std::string name, ending;
        std::function<std::string()> make;
    };
    void run();
    std::string do_it(const Errand& errand);

    std::function<void()> on_done_;
    std::mutex mutex_;
    std::condition_variable changed_;
    std::deque<Errand> waiting_;
    std::vector<std::string> news_;
    bool is_busy_ = false, is_ending_ = false;
    std::thread thread_;
};

}  // namespace qs_view
