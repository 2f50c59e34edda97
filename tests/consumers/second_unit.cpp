// Linked with app/main.cpp: what a header defines and does not say `inline` to is there twice, and does not link. With headers alone, a
// Renderer says what it does not have.
#include <cstdlib>
#include <string>
#include <tilemesh/tilemesh.hpp>

namespace {
bool says(tilemesh::RendererOptions const& options, char const* what)
{
    try {
        tilemesh::Renderer{{}, options};
    } catch (tilemesh::Error const& error) {
        return std::string(error.what()).starts_with(std::string(what) + " in a program that has headers alone");
    }
    return false;
}
[[maybe_unused]] bool const all_said = [] {
    tilemesh::RendererOptions homes, checked, traced;
    homes.program = tilemesh::report::Program::homes;
    checked.engine = tilemesh::render::EngineKind::checked;
    traced.trace = true;
    if (!says(homes, "the program of homes") || !says(checked, "an engine that checks") || !says(traced, "a trace")) std::abort();
    return true;
}();
} // namespace
