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

    // Writes a file, in the errands' thread, and returns its name.
    using Errand = std::function<std::string()>;
    void add(Errand errand);
    // `make` has the bytes; called in the errands' thread.  Without a name a new file is made:
    // qs-view-0001.ENDING, or the first number that there is no file of.
    void write(const std::string& name, const std::string& ending, std::function<std::string()> make);

    // What was done or went wrong since the last call, a sentence each; those that went wrong are told to
    // core::fail(), too.
    std::vector<std::string> news();
    bool are_done();
    // Waits until all is done.
    void finish();

  private:
    void run();
    static std::string do_it(const Errand& errand);

    std::function<void()> on_done_;
    std::mutex mutex_;
    std::condition_variable changed_;
    std::deque<Errand> waiting_;
    std::vector<std::string> news_;
    bool is_busy_ = false, is_ending_ = false;
    std::thread thread_;
};

}  // namespace qs_view
