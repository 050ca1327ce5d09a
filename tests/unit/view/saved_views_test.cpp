#include "view/saved_views.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "cameras.h"
#include "core/error.h"

namespace {

namespace fs = std::filesystem;

// A state folder of the test's own, empty at first.
class SavedViews : public testing::Test {
  protected:
    void SetUp() override {
        std::string name = (fs::temp_directory_path() / "saved-views-XXXXXX").string();
        ASSERT_NE(mkdtemp(name.data()), nullptr);
        place_ = name;
        setenv("XDG_STATE_HOME", (place_ / "state").c_str(), 1);
    }
    void TearDown() override {
        unsetenv("XDG_STATE_HOME");
        fs::remove_all(place_);
    }
    fs::path place_;
};

TEST_F(SavedViews, AreThereForWhoAsksNextToTheBit) {
    const std::string folder = view::views_folder({"scan.qs"});
    EXPECT_EQ(view::read_view(folder, 0), std::nullopt);
    std::mt19937_64 random(1);
    for (const size_t number : {0u, 8u, 0u}) {
        const geom::Camera camera = some_camera(random, 1e6);
        view::write_view(folder, number, camera);
        const std::optional<geom::Camera> read = view::read_view(folder, number);
        ASSERT_TRUE(read.has_value());
        EXPECT_EQ(geom::format_camera(*read), geom::format_camera(camera));
    }
    EXPECT_EQ(view::read_view(folder, 1), std::nullopt);
    EXPECT_EQ(std::distance(fs::directory_iterator(folder), {}), 2) << "something was left beside them";
}

TEST_F(SavedViews, AreNobodyElses) {
    const std::string folder = view::views_folder({"scan.qs"});
    view::write_view(folder, 0, {});
    struct stat status {};
    ASSERT_EQ(stat(folder.c_str(), &status), 0);
    EXPECT_EQ(status.st_mode & 0777, 0700u);
}

TEST_F(SavedViews, AreOfOneSourceWhateverItIsCalled) {
    fs::create_directory(place_ / "models");
    std::ofstream(place_ / "models" / "scan.qs") << "a model";
    fs::create_symlink("models/scan.qs", place_ / "scan.qs");
    const auto folder = [&](const char* name) {
        return fs::path(view::views_folder({(place_ / name).string()}));
    };
    EXPECT_EQ(folder("scan.qs"), folder("models/scan.qs"));
    EXPECT_EQ(folder("models/../models/scan.qs"), folder("models/scan.qs"));
    EXPECT_NE(folder("models/other.qs"), folder("models/scan.qs"));
    EXPECT_NE(folder("other/scan.qs"), folder("models/scan.qs"));
    EXPECT_TRUE(folder("scan.qs").filename().string().starts_with("scan.qs-"));
}

TEST_F(SavedViews, AreApartForEachAddressAndPlacement) {
    const std::vector<std::vector<std::string>> sources{
        {"https://a.example/scan.qs"},
        {"https://b.example/scan.qs"},
        {"ppve:./socket"},
        {"ppve://a:1"},
        {"scan.qs"},
        {"scan.qs@1,0,0"},
        {"scan.qs", "scan.qs"},
    };
    std::vector<std::string> folders;
    for (const auto& source : sources) {
        folders.push_back(view::views_folder(source));
        EXPECT_EQ(fs::path(folders.back()).parent_path(), place_ / "state" / "qs-view");
    }
    std::sort(folders.begin(), folders.end());
    EXPECT_EQ(std::unique(folders.begin(), folders.end()), folders.end());
}

TEST_F(SavedViews, ThatAreDamagedAreRefusedByName) {
    const std::string folder = view::views_folder({"scan.qs"});
    const std::string name = view::write_view(folder, 2, {});
    const std::string line = geom::format_camera({});
    for (const std::string& text : {std::string(), std::string("{"), line + line}) {
        std::ofstream(name) << text;
        try {
            view::read_view(folder, 2);
            ADD_FAILURE() << "taken: " << text;
        } catch (const core::Error& error) {
            EXPECT_NE(std::string(error.what()).find(name), std::string::npos) << error.what();
        }
    }
}

TEST_F(SavedViews, NeedAFolderOfTheUsers) {
    unsetenv("XDG_STATE_HOME");
    const std::string home = std::getenv("HOME") ? std::getenv("HOME") : "";
    unsetenv("HOME");
    EXPECT_THROW(view::views_folder({"scan.qs"}), core::Error);
    setenv("HOME", place_.c_str(), 1);
    EXPECT_TRUE(view::views_folder({"scan.qs"}).starts_with((place_ / ".local/state/qs-view").string()));
    setenv("HOME", home.c_str(), 1);
}

}  // namespace
