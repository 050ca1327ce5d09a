// Header fields that are sent along to some servers, to be let in: a file of lines
//
//     # models of the institute
//     https://models.example.org/private/ Authorization: Bearer 0123456789
//
// a URL that ends with "/", and the field for all URLs that begin with it.  Secrets stand in it, so it must
// belong to the user and be open to nobody else.
#pragma once

#include <string>
#include <vector>

namespace fetch {

class HeaderRules {
  public:
    HeaderRules() = default;
    // Throws core::Error, in which the file and the line are named.
    explicit HeaderRules(const std::string& path);

    // "Name: value" of each field for the URL, in the order of the file.
    std::vector<std::string> fields_for(const std::string& url) const;

  private:
    struct Rule {
        std::string prefix, field;
    };
    std::vector<Rule> rules_;
};

// $XDG_CONFIG_HOME/qs-fetch/headers or ~/.config/qs-fetch/headers; empty where it is not there.
std::string default_header_rules();

}  // namespace fetch
