#pragma once
#include <tilemesh/report/run_report.hpp>

namespace tilemesh { inline namespace v0_2 { namespace report {

TILEMESH_HOST PhotographMeans photograph_means(RunReport const& run)
{
    PhotographMeans means;
    for (auto const& frame : run.frames) {
        if (!frame.photograph) continue;
        if (!frame.photograph->problem.empty()) {
            ++means.not_compared;
            continue;
        }
        ++means.compared;
        means.psnr_db += frame.photograph->measures.psnr_db;
        means.ssim += frame.photograph->measures.ssim;
        means.l1 += frame.photograph->measures.l1;
    }
    for (auto* const sum : {&means.psnr_db, &means.ssim, &means.l1}) *sum /= static_cast<double>(means.compared);
    return means;
}

}}} // namespace tilemesh::report
