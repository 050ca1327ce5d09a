#include "table.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

namespace stability {
namespace {

struct Row {
    std::string name, quantity;
    const char* relation;
    double bound, measured;
};

std::vector<Row>& rows() {
    static std::vector<Row> table;
    return table;
}

void print_table() {
    std::printf("%-34s %-26s %2s %10s %12s\n", "case", "quantity", "", "bound", "measured");
    for (const Row& r : rows())
        std::printf("%-34s %-26s %2s %10.4g %12.5g\n", r.name.c_str(), r.quantity.c_str(), r.relation,
                    r.bound, r.measured);
}

// False where the file cannot be written.  Names have commas, and no quotes.
bool write_csv(const std::string& path) {
    FILE* const file = std::fopen(path.c_str(), "w");
    if (file == nullptr) return false;
    std::fprintf(file, "case,quantity,relation,bound,measured\n");
    for (const Row& r : rows())
        std::fprintf(file, "\"%s\",\"%s\",%s,%.9g,%.9g\n", r.name.c_str(), r.quantity.c_str(), r.relation,
                     r.bound, r.measured);
    const bool is_written = std::ferror(file) == 0;
    return std::fclose(file) == 0 && is_written;
}

}  // namespace

void expect_at_most(const std::string& row, const std::string& quantity, double measured, double bound) {
    rows().push_back({row, quantity, "<=", bound, measured});
    EXPECT_LE(measured, bound) << row << ": " << quantity;
}

void expect_at_least(const std::string& row, const std::string& quantity, double measured, double bound) {
    rows().push_back({row, quantity, ">=", bound, measured});
    EXPECT_GE(measured, bound) << row << ": " << quantity;
}

}  // namespace stability

int main(int argc, char** argv) {
    testing::InitGoogleTest(&argc, argv);
    const bool has_table = argc == 3 && std::string(argv[1]) == "--table";
    if (argc > 1 && !has_table) {
        std::fprintf(stderr, "stability_tests: %s: not known; try --table FILE.csv\n", argv[1]);
        return 2;
    }
    const int status = RUN_ALL_TESTS();
    if (!testing::GTEST_FLAG(list_tests)) stability::print_table();
    if (has_table && !stability::write_csv(argv[2])) {
        std::fprintf(stderr, "stability_tests: %s: cannot write\n", argv[2]);
        return 1;
    }
    return status;
}
