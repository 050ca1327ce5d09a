#include "fetch/header_rules.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>

#include "core/error.h"
#include "folder.h"

namespace {

using fetch::HeaderRules;
using Fields = std::vector<std::string>;

class HeaderFile : public ::testing::Test {
  protected:
    std::string write(const std::string& text) {
        const std::string path = folder_.path + "/headers";
        std::ofstream(path) << text;
        ::chmod(path.c_str(), 0600);
        return path;
    }
    fetch_test::Folder folder_;
};

TEST_F(HeaderFile, FieldsGoWhereTheyAreForAndNowhereElse) {
    const HeaderRules rules(
        write("# a comment\n\nhttps://host/a/ X-One: 1\r\n  https://host/a/\tX-Two:  2 3 \n"
              "https://host:444/ X-Three: 3"));
    EXPECT_EQ(rules.fields_for("https://host/a/model.qs"), (Fields{"X-One: 1", "X-Two:  2 3"}));
    EXPECT_EQ(rules.fields_for("https://host:444/model.qs"), Fields{"X-Three: 3"});
    for (const char* other :
         {"https://host/model.qs", "http://host/a/model.qs", "https://host.evil/a/model.qs",
          "https://host@evil/a/model.qs", "https://host:4444/model.qs", "https://host/a"})
        EXPECT_EQ(rules.fields_for(other), Fields{}) << other;
}

TEST_F(HeaderFile, IsTheUsersAloneAndShort) {
    const std::string path = write("https://host/ A: b\n");
    ::chmod(path.c_str(), 0640);
    EXPECT_THROW(HeaderRules{path}, core::Error);
    EXPECT_THROW(HeaderRules(write(std::string(70'000, '#'))), core::Error);
    EXPECT_THROW(HeaderRules(folder_.path + "/none"), core::Error);
}

TEST_F(HeaderFile, RefusesLinesThatCouldGoAstray) {
    for (const char* line : {"https://host A: b", "https:// A: b", "host/ A: b", "ftp://host/ A: b",
                             "https://host/a A: b", "https://host/", "https://host/ A", "https://host/ : b",
                             "https://host/ A b: c", "https://host/ A:", "https://host/ Range: bytes=0-1",
                             "https://host/ IF-MATCH: x", "https://host/ A: \x80"})
        EXPECT_THROW(HeaderRules(write(line)), core::Error) << line;
}

}  // namespace
