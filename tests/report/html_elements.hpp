#pragma once
#include "../standard.hpp"

/// Is every element of an HTML page closed in order, but for those that HTML never closes?
inline bool elements_close(std::string const& text)
{
    std::vector<std::string> open;
    for (auto at = text.find('<'); at != std::string::npos; at = text.find('<', at + 1)) {
        if (text.compare(at, 2, "<!") == 0) continue;
        auto const end = text.find('>', at);
        if (end == std::string::npos) return false;
        bool const closes = text[at + 1] == '/';
        auto const from = at + (closes ? 2 : 1);
        auto const name = text.substr(from, text.find_first_of(" />", from) - from);
        if (name == "meta" || name == "img" || text[end - 1] == '/') continue;
        if (!closes) {
            open.push_back(name);
        } else {
            if (open.empty() || open.back() != name) return false;
            open.pop_back();
        }
    }
    return open.empty();
}
