#pragma once
#include "options.hpp"
#include "shots.hpp"
#include <cstddef>
#include <filesystem>
#include <string>

namespace render_map {

/// "frame_0012.png" for frame 12 and ".png".
std::string frame_file(std::size_t frame, std::string const& extension);

/// Makes the folder for the pictures and looks whether everything can be written where it should: better now than after an
/// hour. Gives the folder back; throws `tilemesh::Error` where that is not so, and where the report would overwrite a picture
/// or a file that the run reads.
std::filesystem::path prepare_outputs(Options const& options, std::size_t frames);

/// Standard output, checked: a text that does not arrive there throws `tilemesh::Error`, which ends with `remedy`.
void print(std::string const& text, char const* remedy);

} // namespace render_map
