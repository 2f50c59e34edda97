#pragma once
#include <string>
#include <tilemesh/engine/quiet_change.hpp>
#include <tilemesh/engine/text.hpp>

namespace tilemesh { inline namespace v0_2 { namespace engine {

TILEMESH_HOST std::string QuietChange::text(bool outside) const
{
    std::string what = "a kernel ", where;
    auto const became = [&] { return " was " + std::to_string(before) + " and became " + std::to_string(after) + "; "; };
    switch (kind) {
    case Kind::nothing: break;
    case Kind::vote: what += "voted busy"; break;
    case Kind::message: what += "sent on channel " + engine::text(region); break;
    case Kind::size: what += "changed list " + engine::text(region), where = "its size" + became(); break;
    case Kind::word:
        what += "changed state " + engine::text(region);
        where = "word " + std::to_string(word) + ", at byte " + std::to_string(4 * word) + "," + became();
        break;
    case Kind::item:
        what += "changed list " + engine::text(region);
        where = "word " + std::to_string(word) + " of item " + std::to_string(item) + became();
        break;
    }
    if (outside)
        return what + " on a tile outside the rectangle that was quiet and had no mail (" + where +
               "run_within promises that it is idle); run within a larger one";
    what += " on a tile that was quiet and had no mail (" + where + "Vote says busy while running again without mail would change a word); "
            "vote busy earlier";
    if (kind == Kind::word) what += ", or keep statistics of one pass in a per_pass state";
    return what;
}

}}} // namespace tilemesh::engine
