#pragma once
#include <string>
#include <tilemesh/report/run_report.hpp>

namespace render_map {

/// Says how many pictures lack records or copies, and for the worst picture how many and why: "<problem> (<why>)". The worst picture
/// lacks the most whole records; among equals, the most records and copies. Empty if no picture lacks records or copies.
std::string missing_text(tilemesh::report::RunReport const& run);

} // namespace render_map
