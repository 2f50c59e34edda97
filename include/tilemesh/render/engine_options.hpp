#pragma once
#include <tilemesh/model/no_progress.hpp>
#include <tilemesh/render/renderer_options.hpp>

namespace tilemesh { inline namespace v0_2 { namespace render {

/// Sets what the renderer's options say of an engine. A traced engine explains a program that does not become quiet, unless it has an
/// explanation of its own.
template <bool Traced, class EngineOptions>
void set_engine_options(RendererOptions const& options, EngineOptions& engine)
{
    engine.digest = options.digest;
    if constexpr (requires { engine.threads; }) engine.threads = options.threads;
    if constexpr (requires { engine.most_passes; })
        if (options.most_passes != 0) engine.most_passes = options.most_passes;
    if constexpr (Traced && requires { engine.explain; })
        if (engine.explain == nullptr) engine.explain = explain_no_progress;
}

}}} // namespace tilemesh::render
