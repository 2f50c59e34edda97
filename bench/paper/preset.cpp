#include "machines.hpp"
#include <tilemesh/renderer.hpp>
#include <utility>

paper::PaperFrame paper::render_paper(scene::Map const& map, splat::Camera const& camera, std::uint32_t channel_slots,
                                      std::uint32_t storage_slots, std::uint32_t threads)
{
    // `precise`: the picture is compared with the naive one.
    tilemesh::BasicRenderer<splat::Referenced<splat::Paper>> renderer(map, {.threads = threads,
                                                                            .grid = {grid_columns, grid_rows},
                                                                            .channel_slots = channel_slots,
                                                                            .storage_slots = storage_slots,
                                                                            .arithmetic = splat::Arithmetic::precise});
    auto frame = renderer.render(camera);
    auto model = renderer.model();
    model.arithmetic = splat::Arithmetic::precise;
    return {std::move(frame.image), std::move(frame.report), model};
}
