// The names that headers need to pass programs and their options on, without the option parser (see
// messages.h).
#pragma once

namespace CLI {
class Option;
}

namespace core {
class Program;
}
