// Reports: what --report of every program writes.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/json.h"

namespace core {

// --report FILE: JSON, one object a line.  Empty when the option was not given: is_wanted() false
// and write() does nothing.  commit() as OutputFile; "-" is standard output.
class Report {
  public:
    // Opens the file named by --report.  Throws UsageError where that is one of the job's own inputs or
    // outputs (as OutputFile names them; empty: none).
    Report(const std::vector<std::string>& inputs, const std::vector<std::string>& outputs);
    ~Report();
    bool is_wanted() const;
    bool is_standard_output() const;  // then nothing else is printed there
    void write(const Json& line);
    void commit();

  private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace core
