// qs-view: look at a model in a window.  The work is that of view::Session and qs_view::Viewer.
#include <cstdlib>

#include "core/program.h"
#include "qs-view/arguments.h"
#include "qs-view/viewer.h"
#include "view/session.h"

int main(int argc, char** argv) {
    core::Program program("qs-view", "Look at models in a window.", QS_VERSION);
    qs_view::Arguments arguments;
    qs_view::add_options(program, arguments);
    const int status = program.run(argc, argv, [&] {
        qs_view::check(arguments);
        qs_view::Viewer(arguments).run();
    });
    // A thread that waits for a server or a disk would not notice the end; it has nothing to lose.
    if (view::Session::are_some_left()) std::_Exit(status);
    return status;
}
